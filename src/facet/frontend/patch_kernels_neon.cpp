// SPDX-License-Identifier: BSD-2-Clause
// For 64 bit ARM, where NEON is always there. Like its siblings it must not be compiled with
// contraction to fused multiply-add.
#include "facet/frontend/patch_kernels.h"

#if defined(__aarch64__)

#include <cstddef>
#include <cstring>

#include <arm_neon.h>

namespace facet::internal {
namespace {

constexpr int kLanes = kPatchSide;
constexpr int kHalf = kLanes / 2;

struct Floats {
  float32x4_t low, high;
};

float32x4_t Lerp(float32x4_t a, float32x4_t b, float32x4_t f) {
  return vaddq_f32(a, vmulq_f32(f, vsubq_f32(b, a)));
}

// Low byte: the pixel; high byte: its right neighbour.
float32x4_t Lerp(uint16x4_t pairs, float32x4_t fx) {
  const int32x4_t wide = vreinterpretq_s32_u32(vmovl_u16(pairs));
  const int32x4_t first = vandq_s32(wide, vdupq_n_s32(0xFF));
  const float32x4_t step = vcvtq_f32_s32(vsubq_s32(vshrq_n_s32(wide, 8), first));
  return vaddq_f32(vcvtq_f32_s32(first), vmulq_f32(fx, step));
}

// Gathers 8 pairs of neighbours and interpolates each.
Floats LerpRow(const std::uint8_t* base, const std::int32_t* offsets, const Floats& fx) {
  std::uint16_t pairs[kLanes];
  for (int i = 0; i < kLanes; ++i)
    std::memcpy(pairs + i, base + offsets[i], sizeof(pairs[i]));
  const uint16x8_t all = vld1q_u16(pairs);
  return {Lerp(vget_low_u16(all), fx.low), Lerp(vget_high_u16(all), fx.high)};
}

// The place of four samples of a row: where their pixels are, and how far they are beyond them.
struct FourPlaces {
  FourPlaces(float32x4_t x, float32x4_t y, int step) {
    const int32x4_t ix = vcvtq_s32_f32(x), iy = vcvtq_s32_f32(y);
    offsets = vaddq_s32(vmulq_n_s32(iy, step), ix);
    fx = vsubq_f32(x, vcvtq_f32_s32(ix));
    fy = vsubq_f32(y, vcvtq_f32_s32(iy));
  }
  int32x4_t offsets;
  float32x4_t fx, fy;
};

void Sample(const ImageLevel& image, const PatchWarp& warp, float* values) {
  const float columns[kLanes] = {-3.5F, -2.5F, -1.5F, -0.5F, 0.5F, 1.5F, 2.5F, 3.5F};
  const float32x4_t u_low = vld1q_f32(columns), u_high = vld1q_f32(columns + kHalf);
  const float32x4_t a00 = vdupq_n_f32(warp.a00), a10 = vdupq_n_f32(warp.a10);
  std::int32_t offsets[kLanes];
  for (int r = 0; r < kPatchSide; ++r, values += kLanes) {
    const float v = static_cast<float>(r) - kPatchHalf;
    const float32x4_t row_x = vdupq_n_f32(warp.a01 * v + warp.x);
    const float32x4_t row_y = vdupq_n_f32(warp.a11 * v + warp.y);
    const FourPlaces low(vaddq_f32(vmulq_f32(a00, u_low), row_x),
                         vaddq_f32(vmulq_f32(a10, u_low), row_y),
                         image.step);
    const FourPlaces high(vaddq_f32(vmulq_f32(a00, u_high), row_x),
                          vaddq_f32(vmulq_f32(a10, u_high), row_y),
                          image.step);
    vst1q_s32(offsets, low.offsets);
    vst1q_s32(offsets + kHalf, high.offsets);
    const Floats fx = {low.fx, high.fx};
    const Floats top = LerpRow(image.data, offsets, fx);
    const Floats bottom = LerpRow(image.data + image.step, offsets, fx);
    vst1q_f32(values, Lerp(top.low, bottom.low, low.fy));
    vst1q_f32(values + kHalf, Lerp(top.high, bottom.high, high.fy));
  }
}

float32x4_t LoadPixels(const std::uint8_t* p) {
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, p, sizeof(bytes));
  const uint8x8_t pixels = vcreate_u8(bytes);
  return vcvtq_f32_u32(vmovl_u16(vget_low_u16(vmovl_u8(pixels))));
}

// The place of an upright patch whose first sample is at (x, y).
struct UprightPlace {
  UprightPlace(const ImageLevel& image, float x, float y) {
    const int ix = static_cast<int>(x), iy = static_cast<int>(y);
    first = image.data + static_cast<std::ptrdiff_t>(iy) * image.step + ix;
    fx = vdupq_n_f32(x - static_cast<float>(ix));
    fy = vdupq_n_f32(y - static_cast<float>(iy));
  }
  const std::uint8_t* first;
  float32x4_t fx, fy;
};

// Half of the columns at a time.
void SampleUpright(const ImageLevel& image, float x, float y, float* values) {
  const UprightPlace place(image, x - kPatchHalf, y - kPatchHalf);
  for (int first = 0; first < kLanes; first += kHalf) {
    const std::uint8_t* p = place.first + first;
    float32x4_t above = Lerp(LoadPixels(p), LoadPixels(p + 1), place.fx);
    for (int r = 0; r < kPatchSide; ++r) {
      p += image.step;
      const float32x4_t below = Lerp(LoadPixels(p), LoadPixels(p + 1), place.fx);
      vst1q_f32(values + r * kLanes + first, Lerp(above, below, place.fy));
      above = below;
    }
  }
}

// Some columns of a row of samples, and those one pixel to the left and to the right.
struct WideRow {
  float32x4_t left, centre, right;
};

WideRow LerpColumns(const std::uint8_t* p, float32x4_t fx) {
  const float32x4_t a = LoadPixels(p), b = LoadPixels(p + 1), c = LoadPixels(p + 2);
  return {Lerp(a, b, fx), Lerp(b, c, fx), Lerp(c, LoadPixels(p + 3), fx)};
}

void SampleGradientColumns(
    const UprightPlace& place, int step, float* values, float* grad_x, float* grad_y) {
  const float32x4_t half = vdupq_n_f32(0.5F);
  const std::uint8_t* p = place.first;
  WideRow above = LerpColumns(p, place.fx);
  float32x4_t previous = half, before = half;  // the two rows of samples above
  for (int r = -1; r <= kPatchSide; ++r) {
    p += step;
    const WideRow below = LerpColumns(p, place.fx);
    const float32x4_t centre = Lerp(above.centre, below.centre, place.fy);
    if (r >= 0 && r < kPatchSide) {
      const float32x4_t left = Lerp(above.left, below.left, place.fy);
      const float32x4_t right = Lerp(above.right, below.right, place.fy);
      vst1q_f32(values + r * kLanes, centre);
      vst1q_f32(grad_x + r * kLanes, vmulq_f32(half, vsubq_f32(right, left)));
    }
    if (r >= 1) vst1q_f32(grad_y + (r - 1) * kLanes, vmulq_f32(half, vsubq_f32(centre, before)));
    before = previous;
    previous = centre;
    above = below;
  }
}

void SampleGradient(
    const ImageLevel& image, float x, float y, float* values, float* grad_x, float* grad_y) {
  UprightPlace place(image, x - kPatchHalf - 1, y - kPatchHalf - 1);
  SampleGradientColumns(place, image.step, values, grad_x, grad_y);
  place.first += kHalf;
  SampleGradientColumns(place, image.step, values + kHalf, grad_x + kHalf, grad_y + kHalf);
}

float SumLanes(float32x4_t low, float32x4_t high) {
  const float32x4_t four = vaddq_f32(low, high);
  const float32x2_t two = vadd_f32(vget_low_f32(four), vget_high_f32(four));
  return vget_lane_f32(two, 0) + vget_lane_f32(two, 1);
}

void DotRows(const float* values, const float* rows, int num_rows, float* out) {
  for (int k = 0; k < num_rows; ++k, rows += kPatchSize) {
    float32x4_t low = vdupq_n_f32(0), high = low;
    for (int i = 0; i < kPatchSize; i += kLanes) {
      low = vaddq_f32(low, vmulq_f32(vld1q_f32(values + i), vld1q_f32(rows + i)));
      high = vaddq_f32(high, vmulq_f32(vld1q_f32(values + i + kHalf), vld1q_f32(rows + i + kHalf)));
    }
    out[k] = SumLanes(low, high);
  }
}

void Moments(const float* values, const float* weights, float* sum, float* sum_squares) {
  float32x4_t s[2] = {vdupq_n_f32(0), vdupq_n_f32(0)};
  float32x4_t s2[2] = {vdupq_n_f32(0), vdupq_n_f32(0)};
  for (int i = 0; i < kPatchSize; i += kLanes) {
    for (int h = 0; h < 2; ++h) {
      const float32x4_t value = vld1q_f32(values + i + kHalf * h);
      const float32x4_t wv = vmulq_f32(vld1q_f32(weights + i + kHalf * h), value);
      s[h] = vaddq_f32(s[h], wv);
      s2[h] = vaddq_f32(s2[h], vmulq_f32(wv, value));
    }
  }
  *sum = SumLanes(s[0], s[1]);
  *sum_squares = SumLanes(s2[0], s2[1]);
}

void Combine(const float* rows, const float* factors, int num_rows, float* out) {
  for (int i = 0; i < kPatchSize; i += kHalf, rows += kHalf) {
    float32x4_t sum = vmulq_f32(vdupq_n_f32(factors[0]), vld1q_f32(rows));
    for (int k = 1; k < num_rows; ++k)
      sum = vaddq_f32(sum, vmulq_f32(vdupq_n_f32(factors[k]), vld1q_f32(rows + k * kPatchSize)));
    vst1q_f32(out + i, sum);
  }
}

constexpr PatchKernels kKernels = {
    "neon", Sample, SampleUpright, SampleGradient, DotRows, Moments, Combine};

}  // namespace

const PatchKernels* NeonKernels() {
  return &kKernels;
}

}  // namespace facet::internal

#else

namespace facet::internal {

const PatchKernels* NeonKernels() {
  return nullptr;
}

}  // namespace facet::internal

#endif
