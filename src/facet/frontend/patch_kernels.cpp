// SPDX-License-Identifier: BSD-2-Clause
// Portable kernels, and the choice between the variants.
#include "facet/frontend/patch_kernels.h"

#include <cmath>
#include <cstddef>

namespace facet {
namespace {

constexpr int kLanes = kPatchSide;

// The final order of every sum: lanes l and l + 4, then l and l + 2, then l and l + 1.
float SumLanes(const float* s) {
  const float a = s[0] + s[4], b = s[1] + s[5], c = s[2] + s[6], d = s[3] + s[7];
  return (a + c) + (b + d);
}

void Sample(const ImageLevel& image, const PatchWarp& warp, float* values) {
  for (int r = 0; r < kPatchSide; ++r) {
    const float v = static_cast<float>(r) - kPatchHalf;
    const float row_x = warp.a01 * v + warp.x;
    const float row_y = warp.a11 * v + warp.y;
    for (int c = 0; c < kLanes; ++c) {
      const float u = static_cast<float>(c) - kPatchHalf;
      const float x = warp.a00 * u + row_x;
      const float y = warp.a10 * u + row_y;
      const int ix = static_cast<int>(x), iy = static_cast<int>(y);
      const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
      const std::uint8_t* p = image.data + static_cast<std::ptrdiff_t>(iy) * image.step + ix;
      const std::uint8_t* q = p + image.step;
      const float top = static_cast<float>(p[0]) + fx * static_cast<float>(p[1] - p[0]);
      const float bottom = static_cast<float>(q[0]) + fx * static_cast<float>(q[1] - q[0]);
      values[r * kLanes + c] = top + fy * (bottom - top);
    }
  }
}

void SampleUpright(const ImageLevel& image, float x, float y, float* values) {
  const float left = x - kPatchHalf, top = y - kPatchHalf;
  const int ix = static_cast<int>(left), iy = static_cast<int>(top);
  const float fx = left - static_cast<float>(ix), fy = top - static_cast<float>(iy);
  alignas(32) float rows[2][kPatchSide];
  const std::uint8_t* p = image.data + static_cast<std::ptrdiff_t>(iy) * image.step + ix;
  for (int r = 0; r <= kPatchSide; ++r, p += image.step) {
    float* below = rows[r & 1];
    for (int c = 0; c < kPatchSide; ++c) {
      const float a = p[c], b = p[c + 1];
      below[c] = a + fx * (b - a);
    }
    if (r == 0) continue;
    const float* above = rows[1 - (r & 1)];
    float* out = values + (r - 1) * kPatchSide;
    for (int c = 0; c < kPatchSide; ++c)
      out[c] = above[c] + fy * (below[c] - above[c]);
  }
}

void SampleGradient(
    const ImageLevel& image, float x, float y, float* values, float* grad_x, float* grad_y) {
  // Two columns and rows more than the patch for the differences.
  constexpr int kSide = kPatchSide + 2;
  const float left = x - kPatchHalf - 1, top = y - kPatchHalf - 1;
  const int ix = static_cast<int>(left), iy = static_cast<int>(top);
  const float fx = left - static_cast<float>(ix), fy = top - static_cast<float>(iy);
  float above[kSide], below[kSide];
  float patch[kSide * kSide];
  const std::uint8_t* p = image.data + static_cast<std::ptrdiff_t>(iy) * image.step + ix;
  for (int r = 0; r <= kSide; ++r, p += image.step) {
    float* row = (r & 1) != 0 ? below : above;
    const float* other = (r & 1) != 0 ? above : below;
    for (int c = 0; c < kSide; ++c) {
      const float a = p[c], b = p[c + 1];
      row[c] = a + fx * (b - a);
    }
    if (r == 0) continue;
    float* out = patch + (r - 1) * kSide;
    for (int c = 0; c < kSide; ++c)
      out[c] = other[c] + fy * (row[c] - other[c]);
  }
  for (int r = 0; r < kPatchSide; ++r) {
    const float* centre = patch + (r + 1) * kSide + 1;
    for (int c = 0; c < kPatchSide; ++c) {
      values[r * kPatchSide + c] = centre[c];
      grad_x[r * kPatchSide + c] = 0.5F * (centre[c + 1] - centre[c - 1]);
      grad_y[r * kPatchSide + c] = 0.5F * (centre[c + kSide] - centre[c - kSide]);
    }
  }
}

void DotRows(const float* values, const float* rows, int num_rows, float* out) {
  for (int k = 0; k < num_rows; ++k, rows += kPatchSize) {
    float sum[kLanes] = {};
    for (int i = 0; i < kPatchSize; i += kLanes) {
      for (int l = 0; l < kLanes; ++l)
        sum[l] += values[i + l] * rows[i + l];
    }
    out[k] = SumLanes(sum);
  }
}

void Moments(const float* values, const float* weights, float* sum, float* sum_squares) {
  float s[kLanes] = {}, s2[kLanes] = {};
  for (int i = 0; i < kPatchSize; i += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      const float wv = weights[i + l] * values[i + l];
      s[l] += wv;
      s2[l] += wv * values[i + l];
    }
  }
  *sum = SumLanes(s);
  *sum_squares = SumLanes(s2);
}

void Combine(const float* rows, const float* factors, int num_rows, float* out) {
  for (int i = 0; i < kPatchSize; ++i) {
    float sum = factors[0] * rows[i];
    for (int k = 1; k < num_rows; ++k)
      sum += factors[k] * rows[k * kPatchSize + i];
    out[i] = sum;
  }
}

constexpr PatchKernels kScalarKernels = {
    "scalar", Sample, SampleUpright, SampleGradient, DotRows, Moments, Combine};

}  // namespace

bool CanSample(const ImageLevel& image, const PatchWarp& warp) {
  const float extent_x = kPatchHalf * (std::abs(warp.a00) + std::abs(warp.a01));
  const float extent_y = kPatchHalf * (std::abs(warp.a10) + std::abs(warp.a11));
  // A sample reads its pixel and the next; half a pixel more absorbs rounding.
  return warp.x - extent_x >= 0 && warp.x + extent_x < static_cast<float>(image.width) - 1.5F &&
         warp.y - extent_y >= 0 && warp.y + extent_y < static_cast<float>(image.height) - 1.5F;
}

bool CanSampleGradient(const ImageLevel& image, float x, float y) {
  constexpr float kReach = kPatchHalf + 1;
  return x - kReach >= 0 && x + kReach < static_cast<float>(image.width) - 1.5F &&
         y - kReach >= 0 && y + kReach < static_cast<float>(image.height) - 2.5F;
}

const PatchKernels* FindPatchKernels(const std::string& name) {
  const PatchKernels* const sse2 = internal::Sse2Kernels();
  const PatchKernels* const avx2 = internal::Avx2Kernels();
  const PatchKernels* const neon = internal::NeonKernels();
  if (name == "scalar") return &kScalarKernels;
  if (name == "sse2") return sse2;
  if (name == "avx2") return avx2;
  if (name == "neon") return neon;
  if (name != "auto") return nullptr;
  if (neon != nullptr) return neon;
  if (avx2 != nullptr) return avx2;
  return sse2 != nullptr ? sse2 : &kScalarKernels;
}

}  // namespace facet
