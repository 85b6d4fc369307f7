// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/halved_image.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "facet/base/check.h"

namespace facet {
namespace {

static_assert(std::endian::native == std::endian::little, "the low byte of a pair is the left one");

constexpr int kTaps = 5;
using RowPointers = std::array<const std::uint8_t*, kTaps>;

// So many numbers of 16 bits that a processor adds at once.
template <int kNumbers>
struct Wide {
  typedef std::uint16_t Numbers __attribute__((vector_size(2 * kNumbers)));  // NOLINT: g++ needs it
  typedef std::uint8_t Bytes __attribute__((vector_size(kNumbers)));         // NOLINT
};

// (1 4 6 4 1): the last sum, with 255 everywhere, is 65280 and with what rounds it 65408.
template <class Number>
[[gnu::always_inline]] inline void Filter(const Number (&taps)[kTaps], Number& sum) {
  sum = taps[0] + taps[4] + ((taps[1] + taps[2] + taps[3]) << 2) + (taps[2] << 1);
}

// Of a row that is filtered across the image's rows: even[i] is column 2i, odd[i] column 2i + 1.
struct FilteredRow {
  std::uint16_t* even;
  std::uint16_t* odd;
};

// Calls f.operator()<n>(i) for all numbers i to i + n - 1 below `num`: kNumbers at once, the last
// of them a second time where it is not a multiple, or one at a time if there are fewer.
template <int kNumbers, class Function>
[[gnu::always_inline]] inline void OverAll(int num, const Function& f) {
  if (num < kNumbers) {
    for (int i = 0; i < num; ++i)
      f.template operator()<1>(i);
    return;
  }
  for (int i = 0; i < num; i += kNumbers)
    f.template operator()<kNumbers>(std::min(i, num - kNumbers));
}

template <int kNumbers>
[[gnu::always_inline]] inline void FilterRows(const RowPointers& rows,
                                              int width,
                                              const FilteredRow& to) {
  OverAll<kNumbers>(
      width / 2, [&]<int kNum>(int i) __attribute__((always_inline)) {
        typename Wide<kNum>::Numbers pairs, left[kTaps], right[kTaps], sum;
        for (int k = 0; k < kTaps; ++k) {
          std::memcpy(&pairs, rows[k] + 2 * i, sizeof(pairs));
          left[k] = pairs & 255;
          right[k] = pairs >> 8;
        }
        Filter(left, sum);
        std::memcpy(to.even + i, &sum, sizeof(sum));
        Filter(right, sum);
        std::memcpy(to.odd + i, &sum, sizeof(sum));
      });
  if (width % 2 == 0) return;
  int taps[kTaps], sum = 0;
  for (int k = 0; k < kTaps; ++k)
    taps[k] = rows[k][width - 1];
  Filter(taps, sum);
  to.even[width / 2] = static_cast<std::uint16_t>(sum);
}

// Columns -2, -1 and those behind the last one that an even column in the image needs.
void MirrorEnds(int width, const FilteredRow& row) {
  const auto at = [&row](int x) -> std::uint16_t& {
    return (x % 2 == 0 ? row.even : row.odd)[x / 2];
  };
  row.even[-1] = at(2);
  row.odd[-1] = at(1);
  for (int x = width; x < width + 2; ++x)
    at(x) = at(2 * (width - 1) - x);
}

template <int kNumbers>
[[gnu::always_inline]] inline void FilterColumns(const FilteredRow& row,
                                                 int half_width,
                                                 std::uint8_t* to) {
  OverAll<kNumbers>(
      half_width, [&]<int kNum>(int i) __attribute__((always_inline)) {
        typename Wide<kNum>::Numbers taps[kTaps], sum;
        std::memcpy(&taps[0], row.even - 1 + i, sizeof(sum));
        std::memcpy(&taps[1], row.odd - 1 + i, sizeof(sum));
        std::memcpy(&taps[2], row.even + i, sizeof(sum));
        std::memcpy(&taps[3], row.odd + i, sizeof(sum));
        std::memcpy(&taps[4], row.even + 1 + i, sizeof(sum));
        Filter(taps, sum);
        sum = (sum + 128) >> 8;
        const auto bytes = __builtin_convertvector(sum, typename Wide<kNum>::Bytes);
        std::memcpy(to + i, &bytes, sizeof(bytes));
      });
}

int Mirrored(int i, int size) {
  const int inside = i < 0 ? -i : i;
  return inside < size ? inside : 2 * (size - 1) - inside;
}

template <int kNumbers>
[[gnu::always_inline]] inline void HalveBy(const cv::Mat& image,
                                           const FilteredRow& row,
                                           cv::Mat& half) {
  RowPointers rows;
  for (int y = 0; y < half.rows; ++y) {
    for (int k = 0; k < kTaps; ++k)
      rows[static_cast<std::size_t>(k)] = image.ptr(Mirrored(2 * y + k - kTaps / 2, image.rows));
    FilterRows<kNumbers>(rows, image.cols, row);
    MirrorEnds(image.cols, row);
    FilterColumns<kNumbers>(row, half.cols, half.ptr(y));
  }
}

#ifdef __x86_64__
__attribute__((target("avx2"))) void HalveBySixteen(const cv::Mat& image,
                                                    const FilteredRow& row,
                                                    cv::Mat& half) {
  HalveBy<16>(image, row, half);
}

bool CanAddSixteen() {
  return __builtin_cpu_supports("avx2") != 0;
}
#else
void HalveBySixteen(const cv::Mat& image, const FilteredRow& row, cv::Mat& half) {
  HalveBy<16>(image, row, half);
}

bool CanAddSixteen() {
  return false;
}
#endif

}  // namespace

void ImageHalver::Halve(const cv::Mat& image, cv::Mat& half) {
  FACET_CHECK(image.type() == CV_8UC1) << "only 8 bit grey images are halved";
  FACET_CHECK(image.cols >= 4 && image.rows >= 4) << image.cols << " x " << image.rows;
  half.create((image.rows + 1) / 2, (image.cols + 1) / 2, CV_8UC1);
  const auto size = static_cast<std::size_t>(half.cols) + 2;
  even_.resize(size);
  odd_.resize(size);
  const FilteredRow row{even_.data() + 1, odd_.data() + 1};
  if (max_at_once_ >= 16 && CanAddSixteen()) {
    HalveBySixteen(image, row, half);
  } else {
    HalveBy<8>(image, row, half);
  }
}

}  // namespace facet
