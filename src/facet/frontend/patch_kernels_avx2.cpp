// SPDX-License-Identifier: BSD-2-Clause
// Compiled for AVX2 function by function; only called where the processor has it.
#include "facet/frontend/patch_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__)

#include <cstddef>
#include <cstring>

#include <immintrin.h>

#define FACET_AVX2 __attribute__((target("avx2")))

namespace facet::internal {
namespace {

constexpr int kLanes = kPatchSide;

// Low byte: the pixel; high byte: its right neighbour.
int LoadPair(const std::uint8_t* p) {
  std::uint16_t pair = 0;
  std::memcpy(&pair, p, sizeof(pair));
  return pair;
}

// Single loads: since the microcode fix for CVE-2022-40982 a gather is slower than these.
FACET_AVX2 __m256 LerpRow(const std::uint8_t* base, const int* offsets, __m256 fx) {
  __m128i pairs = _mm_setzero_si128();
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[0]), 0);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[1]), 1);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[2]), 2);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[3]), 3);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[4]), 4);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[5]), 5);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[6]), 6);
  pairs = _mm_insert_epi16(pairs, LoadPair(base + offsets[7]), 7);
  const __m256i wide = _mm256_cvtepu16_epi32(pairs);
  const __m256i first = _mm256_and_si256(wide, _mm256_set1_epi32(0xFF));
  const __m256i second = _mm256_srli_epi32(wide, 8);
  const __m256 step = _mm256_cvtepi32_ps(_mm256_sub_epi32(second, first));
  return _mm256_add_ps(_mm256_cvtepi32_ps(first), _mm256_mul_ps(fx, step));
}

FACET_AVX2 void Sample(const ImageLevel& image, const PatchWarp& warp, float* values) {
  const __m256 u = _mm256_set_ps(3.5F, 2.5F, 1.5F, 0.5F, -0.5F, -1.5F, -2.5F, -3.5F);
  const __m256 du_x = _mm256_mul_ps(_mm256_set1_ps(warp.a00), u);
  const __m256 du_y = _mm256_mul_ps(_mm256_set1_ps(warp.a10), u);
  const __m256i step = _mm256_set1_epi32(image.step);
  alignas(32) int offsets[kLanes];
  for (int r = 0; r < kPatchSide; ++r) {
    const float v = static_cast<float>(r) - kPatchHalf;
    const __m256 x = _mm256_add_ps(du_x, _mm256_set1_ps(warp.a01 * v + warp.x));
    const __m256 y = _mm256_add_ps(du_y, _mm256_set1_ps(warp.a11 * v + warp.y));
    const __m256i ix = _mm256_cvttps_epi32(x), iy = _mm256_cvttps_epi32(y);
    const __m256i offset = _mm256_add_epi32(_mm256_mullo_epi32(iy, step), ix);
    _mm256_store_si256(reinterpret_cast<__m256i*>(offsets), offset);
    const __m256 fx = _mm256_sub_ps(x, _mm256_cvtepi32_ps(ix));
    const __m256 fy = _mm256_sub_ps(y, _mm256_cvtepi32_ps(iy));
    const __m256 top = LerpRow(image.data, offsets, fx);
    const __m256 bottom = LerpRow(image.data + image.step, offsets, fx);
    const __m256 value = _mm256_add_ps(top, _mm256_mul_ps(fy, _mm256_sub_ps(bottom, top)));
    _mm256_store_ps(values + r * kLanes, value);
  }
}

// The compiler would convert them one by one.
FACET_AVX2 __m256 LoadPixels(const std::uint8_t* p) {
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(p));
  return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes));
}

FACET_AVX2 __m256 Lerp(__m256 a, __m256 b, __m256 f) {
  return _mm256_add_ps(a, _mm256_mul_ps(f, _mm256_sub_ps(b, a)));
}

// The place of an upright patch whose first sample is at (x, y).
struct UprightPlace {
  UprightPlace(const ImageLevel& image, float x, float y) {
    const int ix = static_cast<int>(x), iy = static_cast<int>(y);
    first = image.data + static_cast<std::ptrdiff_t>(iy) * image.step + ix;
    fx = x - static_cast<float>(ix);
    fy = y - static_cast<float>(iy);
  }
  const std::uint8_t* first;
  float fx, fy;
};

FACET_AVX2 void SampleUpright(const ImageLevel& image, float x, float y, float* values) {
  const UprightPlace place(image, x - kPatchHalf, y - kPatchHalf);
  const __m256 fx = _mm256_set1_ps(place.fx), fy = _mm256_set1_ps(place.fy);
  const std::uint8_t* p = place.first;
  __m256 above = Lerp(LoadPixels(p), LoadPixels(p + 1), fx);
  for (int r = 0; r < kPatchSide; ++r) {
    p += image.step;
    const __m256 below = Lerp(LoadPixels(p), LoadPixels(p + 1), fx);
    _mm256_store_ps(values + r * kLanes, Lerp(above, below, fy));
    above = below;
  }
}

// A row of samples, and those one pixel to the left and to the right.
struct WideRow {
  __m256 left, centre, right;
};

FACET_AVX2 WideRow LerpColumns(const std::uint8_t* p, __m256 fx) {
  const __m256 a = LoadPixels(p), b = LoadPixels(p + 1), c = LoadPixels(p + 2);
  return {Lerp(a, b, fx), Lerp(b, c, fx), Lerp(c, LoadPixels(p + 3), fx)};
}

FACET_AVX2 void SampleGradient(
    const ImageLevel& image, float x, float y, float* values, float* grad_x, float* grad_y) {
  const UprightPlace place(image, x - kPatchHalf - 1, y - kPatchHalf - 1);
  const __m256 fx = _mm256_set1_ps(place.fx), fy = _mm256_set1_ps(place.fy);
  const __m256 half = _mm256_set1_ps(0.5F);
  const std::uint8_t* p = place.first;
  WideRow above = LerpColumns(p, fx);
  __m256 previous = half, before = half;  // the two rows of samples above
  for (int r = -1; r <= kPatchSide; ++r) {
    p += image.step;
    const WideRow below = LerpColumns(p, fx);
    const __m256 centre = Lerp(above.centre, below.centre, fy);
    if (r >= 0 && r < kPatchSide) {
      const __m256 left = Lerp(above.left, below.left, fy);
      const __m256 right = Lerp(above.right, below.right, fy);
      _mm256_store_ps(values + r * kLanes, centre);
      _mm256_store_ps(grad_x + r * kLanes, _mm256_mul_ps(half, _mm256_sub_ps(right, left)));
    }
    if (r >= 1) {
      const __m256 step = _mm256_sub_ps(centre, before);
      _mm256_store_ps(grad_y + (r - 1) * kLanes, _mm256_mul_ps(half, step));
    }
    before = previous;
    previous = centre;
    above = below;
  }
}

FACET_AVX2 float SumLanes(__m256 s) {
  const __m128 four = _mm_add_ps(_mm256_castps256_ps128(s), _mm256_extractf128_ps(s, 1));
  const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps(two, two, 1)));
}

FACET_AVX2 void DotRows(const float* values, const float* rows, int num_rows, float* out) {
  for (int k = 0; k < num_rows; ++k, rows += kPatchSize) {
    __m256 sum = _mm256_setzero_ps();
    for (int i = 0; i < kPatchSize; i += kLanes) {
      const __m256 product = _mm256_mul_ps(_mm256_load_ps(values + i), _mm256_load_ps(rows + i));
      sum = _mm256_add_ps(sum, product);
    }
    out[k] = SumLanes(sum);
  }
}

FACET_AVX2 void Moments(const float* values, const float* weights, float* sum, float* sum_squares) {
  __m256 s = _mm256_setzero_ps(), s2 = _mm256_setzero_ps();
  for (int i = 0; i < kPatchSize; i += kLanes) {
    const __m256 value = _mm256_load_ps(values + i);
    const __m256 wv = _mm256_mul_ps(_mm256_load_ps(weights + i), value);
    s = _mm256_add_ps(s, wv);
    s2 = _mm256_add_ps(s2, _mm256_mul_ps(wv, value));
  }
  *sum = SumLanes(s);
  *sum_squares = SumLanes(s2);
}

FACET_AVX2 void Combine(const float* rows, const float* factors, int num_rows, float* out) {
  for (int i = 0; i < kPatchSize; i += 16, rows += 16) {
    __m256 factor = _mm256_set1_ps(factors[0]);
    __m256 low = _mm256_mul_ps(factor, _mm256_load_ps(rows));
    __m256 high = _mm256_mul_ps(factor, _mm256_load_ps(rows + 8));
    for (int k = 1; k < num_rows; ++k) {
      const float* row = rows + k * kPatchSize;
      factor = _mm256_set1_ps(factors[k]);
      low = _mm256_add_ps(low, _mm256_mul_ps(factor, _mm256_load_ps(row)));
      high = _mm256_add_ps(high, _mm256_mul_ps(factor, _mm256_load_ps(row + 8)));
    }
    _mm256_store_ps(out + i, low);
    _mm256_store_ps(out + i + 8, high);
  }
}

constexpr PatchKernels kKernels = {
    "avx2", Sample, SampleUpright, SampleGradient, DotRows, Moments, Combine};

}  // namespace

const PatchKernels* Avx2Kernels() {
  return __builtin_cpu_supports("avx2") != 0 ? &kKernels : nullptr;
}

}  // namespace facet::internal

#undef FACET_AVX2

#else

namespace facet::internal {

const PatchKernels* Avx2Kernels() {
  return nullptr;
}

}  // namespace facet::internal

#endif
