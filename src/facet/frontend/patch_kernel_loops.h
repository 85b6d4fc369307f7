// SPDX-License-Identifier: BSD-2-Clause
// A kernel without sums across samples: one loop serves all variants, the compiler vectorises it
// for the instruction set of the function that it is inlined into. Private to the patch_kernels
// files.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "facet/frontend/patch_kernels.h"

namespace facet::internal {

[[gnu::always_inline]] inline void SampleGradientLoop(
    const ImageLevel& image, float x, float y, float* values, float* grad_x, float* grad_y) {
  // Two columns and rows more than the patch for the differences; 16 lanes, of which 10 are used.
  constexpr int kSide = kPatchSide + 2, kLanes = 16;
  const float left = x - kPatchHalf - 1, top = y - kPatchHalf - 1;
  const int ix = static_cast<int>(left), iy = static_cast<int>(top);
  const float fx = left - static_cast<float>(ix), fy = top - static_cast<float>(iy);
  alignas(32) float above[kLanes], below[kLanes];
  alignas(32) float patch[kSide * kLanes];
  const std::uint8_t* p = image.data + static_cast<std::ptrdiff_t>(iy) * image.step + ix;
  for (int r = 0; r <= kSide; ++r, p += image.step) {
    float* row = (r & 1) != 0 ? below : above;
    const float* other = (r & 1) != 0 ? above : below;
    for (int c = 0; c < kLanes; ++c) {
      const float a = p[c], b = p[c + 1];
      row[c] = a + fx * (b - a);
    }
    if (r == 0) continue;
    float* out = patch + (r - 1) * kLanes;
    for (int c = 0; c < kLanes; ++c)
      out[c] = other[c] + fy * (row[c] - other[c]);
  }
  for (int r = 0; r < kPatchSide; ++r) {
    const float* centre = patch + (r + 1) * kLanes + 1;
    for (int c = 0; c < kPatchSide; ++c) {
      values[r * kPatchSide + c] = centre[c];
      grad_x[r * kPatchSide + c] = 0.5F * (centre[c + 1] - centre[c - 1]);
      grad_y[r * kPatchSide + c] = 0.5F * (centre[c + kLanes] - centre[c - kLanes]);
    }
  }
}

}  // namespace facet::internal
