// SPDX-License-Identifier: BSD-2-Clause
// The inner loops of patch tracking, in four variants with bit-identical results: every variant
// does the same roundings in the same order (8 running sums per dot product, fixed final order, no
// fused multiply-add).
#pragma once

#include <cstdint>
#include <string>

namespace facet {

/// One 8 bit image in memory, not owned. Sides and step are below 32768.
struct ImageLevel {
  const std::uint8_t* data = nullptr;
  int step = 0;  ///< bytes from row to row
  int width = 0;
  int height = 0;
};

/// A patch is a square of kPatchSide x kPatchSide samples about its centre.
inline constexpr int kPatchSide = 8;
inline constexpr int kPatchSize = kPatchSide * kPatchSide;
inline constexpr float kPatchHalf = 0.5F * (kPatchSide - 1);
static_assert(kPatchSide == 8, "the kernels handle one row as 8 lanes");

/// Affine map from offsets in a patch to pixels of an image: (x, y) + A (u, v).
struct PatchWarp {
  float a00 = 1, a01 = 0, a10 = 0, a11 = 1;
  float x = 0, y = 0;
};

/// Whether the map only shifts.
inline bool IsUpright(const PatchWarp& warp) {
  return warp.a00 == 1 && warp.a01 == 0 && warp.a10 == 0 && warp.a11 == 1;
}

/// Whether all bilinear samples of the warped patch can be read; false for NaN.
bool CanSample(const ImageLevel& image, const PatchWarp& warp);

/// Whether the upright patch around (x, y) and one more sample on each side can be read.
bool CanSampleGradient(const ImageLevel& image, float x, float y);

/// Arrays are 32 byte aligned and hold kPatchSize values, or several such rows one after the other.
struct PatchKernels {
  const char* name;
  /// Bilinear samples of the warped patch. Requires CanSample.
  void (*sample)(const ImageLevel& image, const PatchWarp& warp, float* values);
  /// Bilinear samples of the upright patch around (x, y). Requires CanSample.
  void (*sample_upright)(const ImageLevel& image, float x, float y, float* values);
  /// Bilinear samples of the upright patch around (x, y), and their central differences. Requires
  /// CanSampleGradient.
  void (*sample_gradient)(
      const ImageLevel& image, float x, float y, float* values, float* grad_x, float* grad_y);
  /// out[k] = sum_i values[i] rows[k][i].
  void (*dot_rows)(const float* values, const float* rows, int num_rows, float* out);
  /// sum_i w[i] values[i] and sum_i w[i] values[i]^2.
  void (*moments)(const float* values, const float* weights, float* sum, float* sum_squares);
  /// out[i] = sum_k factors[k] rows[k][i].
  void (*combine)(const float* rows, const float* factors, int num_rows, float* out);
};

/// "scalar", "sse2", "avx2", "neon", or "auto" for the fastest that this machine has. Null for an
/// unknown name and for a variant that this machine cannot run.
const PatchKernels* FindPatchKernels(const std::string& name);

namespace internal {
/// Null where the compiler's target has no such instructions.
const PatchKernels* Sse2Kernels();
/// Null where this machine has no such instructions.
const PatchKernels* Avx2Kernels();
/// Null on all but 64 bit ARM.
const PatchKernels* NeonKernels();
}  // namespace internal

}  // namespace facet
