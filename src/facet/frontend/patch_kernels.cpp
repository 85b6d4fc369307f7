// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/patch_kernels.h"

#include <cmath>
#include <cstddef>
#include <cstring>

#if defined(__x86_64__)
#define FACET_X86 1
#include <immintrin.h>
#else
#define FACET_X86 0
#endif

namespace facet {
namespace {

constexpr int kLanes = kPatchSide;

// The final order of every sum: lanes l and l + 4, then l and l + 2, then l and l + 1.
float SumLanes(const float* s) {
  const float a = s[0] + s[4], b = s[1] + s[5], c = s[2] + s[6], d = s[3] + s[7];
  return (a + c) + (b + d);
}

namespace scalar {

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

void DotRows(const float* values, const float* rows, int num_rows, float* out) {
  for (int k = 0; k < num_rows; ++k, rows += kPatchSize) {
    float sum[kLanes] = {};
    for (int i = 0; i < kPatchSize; i += kLanes) {
      for (int l = 0; l < kLanes; ++l) sum[l] += values[i + l] * rows[i + l];
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

constexpr PatchKernels kKernels = {"scalar", Sample, DotRows, Moments};

}  // namespace scalar

#if FACET_X86

namespace sse2 {

// Low byte: the pixel; next byte: its right neighbour.
int LoadPair(const std::uint8_t* p) {
  std::uint16_t pair = 0;
  std::memcpy(&pair, p, sizeof(pair));
  return pair;
}

__m128 LerpPairs(__m128i pairs, __m128 fx) {
  const __m128i first = _mm_and_si128(pairs, _mm_set1_epi32(0xFF));
  const __m128i second = _mm_srli_epi32(pairs, 8);
  const __m128 step = _mm_cvtepi32_ps(_mm_sub_epi32(second, first));
  return _mm_add_ps(_mm_cvtepi32_ps(first), _mm_mul_ps(fx, step));
}

__m128 SampleFour(const ImageLevel& image, __m128 x, __m128 y) {
  const __m128i ix = _mm_cvttps_epi32(x), iy = _mm_cvttps_epi32(y);
  alignas(16) int xi[4], yi[4];
  _mm_store_si128(reinterpret_cast<__m128i*>(xi), ix);
  _mm_store_si128(reinterpret_cast<__m128i*>(yi), iy);
  const std::uint8_t* p[4];
  for (int l = 0; l < 4; ++l) {
    p[l] = image.data + static_cast<std::ptrdiff_t>(yi[l]) * image.step + xi[l];
  }
  const __m128i above =
      _mm_set_epi32(LoadPair(p[3]), LoadPair(p[2]), LoadPair(p[1]), LoadPair(p[0]));
  const __m128i below = _mm_set_epi32(LoadPair(p[3] + image.step),
                                      LoadPair(p[2] + image.step),
                                      LoadPair(p[1] + image.step),
                                      LoadPair(p[0] + image.step));
  const __m128 fx = _mm_sub_ps(x, _mm_cvtepi32_ps(ix));
  const __m128 fy = _mm_sub_ps(y, _mm_cvtepi32_ps(iy));
  const __m128 top = LerpPairs(above, fx), bottom = LerpPairs(below, fx);
  return _mm_add_ps(top, _mm_mul_ps(fy, _mm_sub_ps(bottom, top)));
}

void Sample(const ImageLevel& image, const PatchWarp& warp, float* values) {
  const __m128 u_low = _mm_set_ps(-0.5F, -1.5F, -2.5F, -3.5F);
  const __m128 u_high = _mm_set_ps(3.5F, 2.5F, 1.5F, 0.5F);
  const __m128 a00 = _mm_set1_ps(warp.a00), a10 = _mm_set1_ps(warp.a10);
  for (int r = 0; r < kPatchSide; ++r, values += kLanes) {
    const float v = static_cast<float>(r) - kPatchHalf;
    const __m128 row_x = _mm_set1_ps(warp.a01 * v + warp.x);
    const __m128 row_y = _mm_set1_ps(warp.a11 * v + warp.y);
    const __m128 x_low = _mm_add_ps(_mm_mul_ps(a00, u_low), row_x);
    const __m128 y_low = _mm_add_ps(_mm_mul_ps(a10, u_low), row_y);
    const __m128 x_high = _mm_add_ps(_mm_mul_ps(a00, u_high), row_x);
    const __m128 y_high = _mm_add_ps(_mm_mul_ps(a10, u_high), row_y);
    _mm_store_ps(values, SampleFour(image, x_low, y_low));
    _mm_store_ps(values + 4, SampleFour(image, x_high, y_high));
  }
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

constexpr PatchKernels kKernels = {"sse2", Sample, DotRows, Moments};

}  // namespace sse2

namespace avx2 {

#define FACET_AVX2 __attribute__((target("avx2")))

FACET_AVX2 __m256 LerpPairs(__m256i words, __m256 fx) {
  const __m256i mask = _mm256_set1_epi32(0xFF);
  const __m256i first = _mm256_and_si256(words, mask);
  const __m256i second = _mm256_and_si256(_mm256_srli_epi32(words, 8), mask);
  const __m256 step = _mm256_cvtepi32_ps(_mm256_sub_epi32(second, first));
  return _mm256_add_ps(_mm256_cvtepi32_ps(first), _mm256_mul_ps(fx, step));
}

FACET_AVX2 void Sample(const ImageLevel& image, const PatchWarp& warp, float* values) {
  const __m256 u = _mm256_set_ps(3.5F, 2.5F, 1.5F, 0.5F, -0.5F, -1.5F, -2.5F, -3.5F);
  const __m256 du_x = _mm256_mul_ps(_mm256_set1_ps(warp.a00), u);
  const __m256 du_y = _mm256_mul_ps(_mm256_set1_ps(warp.a10), u);
  const __m256i step = _mm256_set1_epi32(image.step);
  const int* above = reinterpret_cast<const int*>(image.data);
  const int* below = reinterpret_cast<const int*>(image.data + image.step);
  for (int r = 0; r < kPatchSide; ++r) {
    const float v = static_cast<float>(r) - kPatchHalf;
    const __m256 x = _mm256_add_ps(du_x, _mm256_set1_ps(warp.a01 * v + warp.x));
    const __m256 y = _mm256_add_ps(du_y, _mm256_set1_ps(warp.a11 * v + warp.y));
    const __m256i ix = _mm256_cvttps_epi32(x), iy = _mm256_cvttps_epi32(y);
    const __m256i offset = _mm256_add_epi32(_mm256_mullo_epi32(iy, step), ix);
    const __m256 fx = _mm256_sub_ps(x, _mm256_cvtepi32_ps(ix));
    const __m256 fy = _mm256_sub_ps(y, _mm256_cvtepi32_ps(iy));
    const __m256 top = LerpPairs(_mm256_i32gather_epi32(above, offset, 1), fx);
    const __m256 bottom = LerpPairs(_mm256_i32gather_epi32(below, offset, 1), fx);
    const __m256 value = _mm256_add_ps(top, _mm256_mul_ps(fy, _mm256_sub_ps(bottom, top)));
    _mm256_store_ps(values + r * kLanes, value);
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

#undef FACET_AVX2

constexpr PatchKernels kKernels = {"avx2", Sample, DotRows, Moments};

bool IsSupported() { return __builtin_cpu_supports("avx2") != 0; }

}  // namespace avx2

#endif  // FACET_X86

}  // namespace

bool CanSample(const ImageLevel& image, const PatchWarp& warp) {
  const float extent_x = kPatchHalf * (std::abs(warp.a00) + std::abs(warp.a01));
  const float extent_y = kPatchHalf * (std::abs(warp.a10) + std::abs(warp.a11));
  // The AVX2 gather reads 4 bytes from the left one of two neighbours; the halves absorb rounding.
  return warp.x - extent_x >= 0 && warp.x + extent_x < static_cast<float>(image.width) - 4.5F &&
         warp.y - extent_y >= 0 && warp.y + extent_y < static_cast<float>(image.height) - 1.5F;
}

const PatchKernels* FindPatchKernels(const std::string& name) {
  if (name == "scalar") return &scalar::kKernels;
#if FACET_X86
  if (name == "sse2") return &sse2::kKernels;
  if (name == "avx2") return avx2::IsSupported() ? &avx2::kKernels : nullptr;
  if (name == "auto") return avx2::IsSupported() ? &avx2::kKernels : &sse2::kKernels;
#else
  if (name == "auto") return &scalar::kKernels;
#endif
  return nullptr;
}

}  // namespace facet
