// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/patch_kernels.h"

#if defined(__SSE2__)

#include <cstddef>
#include <cstring>

#include <emmintrin.h>

namespace facet::internal {
namespace {

constexpr int kLanes = kPatchSide;

// Low byte: the pixel; high byte: its right neighbour.
int LoadPair(const std::uint8_t* p) {
  std::uint16_t pair = 0;
  std::memcpy(&pair, p, sizeof(pair));
  return pair;
}

struct Floats {
  __m128 low, high;
};

__m128 Lerp(__m128i pairs, __m128 fx) {
  const __m128i first = _mm_and_si128(pairs, _mm_set1_epi32(0xFF));
  const __m128i second = _mm_srli_epi32(pairs, 8);
  const __m128 step = _mm_cvtepi32_ps(_mm_sub_epi32(second, first));
  return _mm_add_ps(_mm_cvtepi32_ps(first), _mm_mul_ps(fx, step));
}

// Gathers 8 pairs of neighbours and interpolates each.
Floats LerpRow(const std::uint8_t* base, const int* offsets, __m128 fx_low, __m128 fx_high) {
  __m128i pairs = _mm_setzero_si128();
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[0]), 0);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[1]), 1);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[2]), 2);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[3]), 3);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[4]), 4);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[5]), 5);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[6]), 6);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[7]), 7);
  const __m128i zero = _mm_setzero_si128();
  return {Lerp(_mm_unpacklo_epi16(pairs, zero), fx_low),
          Lerp(_mm_unpackhi_epi16(pairs, zero), fx_high)};
}

// iy * step + ix; sides and steps are below 2^15.
__m128i Offsets(__m128i ix, __m128i iy, __m128i step_and_one) {
  return _mm_madd_epi16(_mm_or_si128(ix, _mm_slli_epi32(iy, 16)), step_and_one);
}

__m128 Fraction(__m128 x, __m128i ix) {
  return _mm_sub_ps(x, _mm_cvtepi32_ps(ix));
}

void Sample(const ImageLevel& image, const PatchWarp& warp, float* values) {
  const __m128 u_low = _mm_set_ps(-0.5F, -1.5F, -2.5F, -3.5F);
  const __m128 u_high = _mm_set_ps(3.5F, 2.5F, 1.5F, 0.5F);
  const __m128 a00 = _mm_set1_ps(warp.a00), a10 = _mm_set1_ps(warp.a10);
  const __m128i step_and_one =
      _mm_set1_epi32(static_cast<int>((static_cast<unsigned>(image.step) << 16) | 1U));
  alignas(16) int offsets[kLanes];
  for (int r = 0; r < kPatchSide; ++r, values += kLanes) {
    const float v = static_cast<float>(r) - kPatchHalf;
    const __m128 row_x = _mm_set1_ps(warp.a01 * v + warp.x);
    const __m128 row_y = _mm_set1_ps(warp.a11 * v + warp.y);
    const Floats x = {_mm_add_ps(_mm_mul_ps(a00, u_low), row_x),
                      _mm_add_ps(_mm_mul_ps(a00, u_high), row_x)};
    const Floats y = {_mm_add_ps(_mm_mul_ps(a10, u_low), row_y),
                      _mm_add_ps(_mm_mul_ps(a10, u_high), row_y)};
    const __m128i ix_low = _mm_cvttps_epi32(x.low), ix_high = _mm_cvttps_epi32(x.high);
    const __m128i iy_low = _mm_cvttps_epi32(y.low), iy_high = _mm_cvttps_epi32(y.high);
    auto* const out = reinterpret_cast<__m128i*>(offsets);
    _mm_store_si128(out, Offsets(ix_low, iy_low, step_and_one));
    _mm_store_si128(out + 1, Offsets(ix_high, iy_high, step_and_one));
    const Floats fx = {Fraction(x.low, ix_low), Fraction(x.high, ix_high)};
    const Floats fy = {Fraction(y.low, iy_low), Fraction(y.high, iy_high)};
    const Floats top = LerpRow(image.data, offsets, fx.low, fx.high);
    const Floats bottom = LerpRow(image.data + image.step, offsets, fx.low, fx.high);
    const __m128 low = _mm_mul_ps(fy.low, _mm_sub_ps(bottom.low, top.low));
    const __m128 high = _mm_mul_ps(fy.high, _mm_sub_ps(bottom.high, top.high));
    _mm_store_ps(values, _mm_add_ps(top.low, low));
    _mm_store_ps(values + 4, _mm_add_ps(top.high, high));
  }
}

// Four pixels. The compiler would convert them one by one.
__m128 LoadPixels(const std::uint8_t* p) {
  int bytes = 0;
  std::memcpy(&bytes, p, sizeof(bytes));
  const __m128i zero = _mm_setzero_si128();
  const __m128i words = _mm_unpacklo_epi8(_mm_cvtsi32_si128(bytes), zero);
  return _mm_cvtepi32_ps(_mm_unpacklo_epi16(words, zero));
}

__m128 Lerp(__m128 a, __m128 b, __m128 f) {
  return _mm_add_ps(a, _mm_mul_ps(f, _mm_sub_ps(b, a)));
}

// The place of an upright patch whose first sample is at (x, y).
struct UprightPlace {
  UprightPlace(const ImageLevel& image, float x, float y) {
    const int ix = static_cast<int>(x), iy = static_cast<int>(y);
    first = image.data + static_cast<std::ptrdiff_t>(iy) * image.step + ix;
    fx = _mm_set1_ps(x - static_cast<float>(ix));
    fy = _mm_set1_ps(y - static_cast<float>(iy));
  }
  const std::uint8_t* first;
  __m128 fx, fy;
};

// Half of the columns at a time.
void SampleUpright(const ImageLevel& image, float x, float y, float* values) {
  const UprightPlace place(image, x - kPatchHalf, y - kPatchHalf);
  for (int first = 0; first < kLanes; first += kLanes / 2) {
    const std::uint8_t* p = place.first + first;
    __m128 above = Lerp(LoadPixels(p), LoadPixels(p + 1), place.fx);
    for (int r = 0; r < kPatchSide; ++r) {
      p += image.step;
      const __m128 below = Lerp(LoadPixels(p), LoadPixels(p + 1), place.fx);
      _mm_store_ps(values + r * kLanes + first, Lerp(above, below, place.fy));
      above = below;
    }
  }
}

// Some columns of a row of samples, and those one pixel to the left and to the right.
struct WideRow {
  __m128 left, centre, right;
};

WideRow LerpColumns(const std::uint8_t* p, __m128 fx) {
  const __m128 a = LoadPixels(p), b = LoadPixels(p + 1), c = LoadPixels(p + 2);
  return {Lerp(a, b, fx), Lerp(b, c, fx), Lerp(c, LoadPixels(p + 3), fx)};
}

void SampleGradientColumns(
    const UprightPlace& place, int step, float* values, float* grad_x, float* grad_y) {
  const __m128 half = _mm_set1_ps(0.5F);
  const std::uint8_t* p = place.first;
  WideRow above = LerpColumns(p, place.fx);
  __m128 previous = half, before = half;  // the two rows of samples above
  for (int r = -1; r <= kPatchSide; ++r) {
    p += step;
    const WideRow below = LerpColumns(p, place.fx);
    const __m128 centre = Lerp(above.centre, below.centre, place.fy);
    if (r >= 0 && r < kPatchSide) {
      const __m128 left = Lerp(above.left, below.left, place.fy);
      const __m128 right = Lerp(above.right, below.right, place.fy);
      _mm_store_ps(values + r * kLanes, centre);
      _mm_store_ps(grad_x + r * kLanes, _mm_mul_ps(half, _mm_sub_ps(right, left)));
    }
    if (r >= 1)
      _mm_store_ps(grad_y + (r - 1) * kLanes, _mm_mul_ps(half, _mm_sub_ps(centre, before)));
    before = previous;
    previous = centre;
    above = below;
  }
}

void SampleGradient(
    const ImageLevel& image, float x, float y, float* values, float* grad_x, float* grad_y) {
  UprightPlace place(image, x - kPatchHalf - 1, y - kPatchHalf - 1);
  SampleGradientColumns(place, image.step, values, grad_x, grad_y);
  constexpr int kHalf = kLanes / 2;
  place.first += kHalf;
  SampleGradientColumns(place, image.step, values + kHalf, grad_x + kHalf, grad_y + kHalf);
}

float SumLanes(__m128 low, __m128 high) {
  const __m128 four = _mm_add_ps(low, high);
  const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps(two, two, 1)));
}

void DotRows(const float* values, const float* rows, int num_rows, float* out) {
  for (int k = 0; k < num_rows; ++k, rows += kPatchSize) {
    __m128 low = _mm_setzero_ps(), high = _mm_setzero_ps();
    for (int i = 0; i < kPatchSize; i += kLanes) {
      low = _mm_add_ps(low, _mm_mul_ps(_mm_load_ps(values + i), _mm_load_ps(rows + i)));
      high = _mm_add_ps(high, _mm_mul_ps(_mm_load_ps(values + i + 4), _mm_load_ps(rows + i + 4)));
    }
    out[k] = SumLanes(low, high);
  }
}

void Moments(const float* values, const float* weights, float* sum, float* sum_squares) {
  __m128 s[2] = {_mm_setzero_ps(), _mm_setzero_ps()};
  __m128 s2[2] = {_mm_setzero_ps(), _mm_setzero_ps()};
  for (int i = 0; i < kPatchSize; i += kLanes) {
    for (int h = 0; h < 2; ++h) {
      const __m128 value = _mm_load_ps(values + i + 4 * h);
      const __m128 wv = _mm_mul_ps(_mm_load_ps(weights + i + 4 * h), value);
      s[h] = _mm_add_ps(s[h], wv);
      s2[h] = _mm_add_ps(s2[h], _mm_mul_ps(wv, value));
    }
  }
  *sum = SumLanes(s[0], s[1]);
  *sum_squares = SumLanes(s2[0], s2[1]);
}

void Combine(const float* rows, const float* factors, int num_rows, float* out) {
  for (int i = 0; i < kPatchSize; i += 8, rows += 8) {
    __m128 factor = _mm_set1_ps(factors[0]);
    __m128 low = _mm_mul_ps(factor, _mm_load_ps(rows));
    __m128 high = _mm_mul_ps(factor, _mm_load_ps(rows + 4));
    for (int k = 1; k < num_rows; ++k) {
      const float* row = rows + k * kPatchSize;
      factor = _mm_set1_ps(factors[k]);
      low = _mm_add_ps(low, _mm_mul_ps(factor, _mm_load_ps(row)));
      high = _mm_add_ps(high, _mm_mul_ps(factor, _mm_load_ps(row + 4)));
    }
    _mm_store_ps(out + i, low);
    _mm_store_ps(out + i + 4, high);
  }
}

constexpr PatchKernels kKernels = {
    "sse2", Sample, SampleUpright, SampleGradient, DotRows, Moments, Combine};

}  // namespace

const PatchKernels* Sse2Kernels() {
  return &kKernels;
}

}  // namespace facet::internal

#else

namespace facet::internal {

const PatchKernels* Sse2Kernels() {
  return nullptr;
}

}  // namespace facet::internal

#endif
