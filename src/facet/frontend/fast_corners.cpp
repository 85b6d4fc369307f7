// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/fast_corners.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "facet/base/check.h"

namespace facet {
namespace {

static_assert(std::endian::native == std::endian::little, "the low byte is the first lane");

constexpr int kLanes = 16, kCircle = 16;
typedef std::uint8_t Bytes __attribute__((vector_size(kLanes)));  // NOLINT: g++ needs a typedef

Bytes Load(const std::uint8_t* p) {
  Bytes bytes;
  std::memcpy(&bytes, p, sizeof(bytes));
  return bytes;
}

Bytes Min(Bytes a, Bytes b) {
  return a < b ? a : b;
}

Bytes Max(Bytes a, Bytes b) {
  return a > b ? a : b;
}

// a - b, or 0 if b is larger.
Bytes Excess(Bytes a, Bytes b) {
  return Max(a, b) - b;
}

bool IsAnyNotZero(Bytes bytes) {
  std::uint64_t halves[2];
  std::memcpy(halves, &bytes, sizeof(bytes));
  return (halves[0] | halves[1]) != 0;
}

/// The distances in memory from a pixel to those around it, clockwise from above.
std::array<std::ptrdiff_t, kCircle> CircleOf(std::ptrdiff_t step) {
  constexpr int kX[kCircle] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
  constexpr int kY[kCircle] = {-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};
  std::array<std::ptrdiff_t, kCircle> circle{};
  for (std::size_t i = 0; i < kCircle; ++i)
    circle[i] = kY[i] * step + kX[i];
  return circle;
}

// For 16 pixels: the largest number that nine differences in a row all reach. Two such arcs share
// eight of them.
Bytes LargestOfNine(const Bytes (&differences)[kCircle]) {
  constexpr int kHalf = kCircle / 2;
  Bytes of_two[kHalf], of_four[kHalf], largest = {};
#pragma GCC unroll 8
  for (int i = 0; i < kHalf; ++i)
    of_two[i] = Min(differences[2 * i + 1], differences[(2 * i + 2) % kCircle]);
#pragma GCC unroll 8
  for (int i = 0; i < kHalf; ++i)
    of_four[i] = Min(of_two[i], of_two[(i + 1) % kHalf]);
#pragma GCC unroll 8
  for (int i = 0; i < kHalf; ++i) {
    const Bytes of_eight = Min(of_four[i], of_four[(i + 2) % kHalf]);
    const Bytes ninth = Max(differences[2 * i], differences[(2 * i + 9) % kCircle]);
    largest = Max(largest, Min(of_eight, ninth));
  }
  return largest;
}

// Nine pixels in a row contain two of the four above, right, below and left, next to each other.
Bytes LargestOfTwo(const Bytes (&compass)[4]) {
  return Min(Max(compass[0], compass[2]), Max(compass[1], compass[3]));
}

// What `difference` of pixel and centre nine in a row reach; less than the threshold or 0 where it
// is not exceeded.
template <class Difference>
Bytes LargestArc(const std::uint8_t* p,
                 const std::array<std::ptrdiff_t, kCircle>& circle,
                 Bytes threshold,
                 const Difference& difference) {
  const Bytes centre = Load(p);
  Bytes compass[4], all[kCircle];
#pragma GCC unroll 4
  for (std::size_t i = 0; i < 4; ++i)
    compass[i] = difference(Load(p + circle[4 * i]), centre);
  if (!IsAnyNotZero(Excess(LargestOfTwo(compass), threshold))) return Bytes{};
#pragma GCC unroll 16
  for (std::size_t i = 0; i < kCircle; ++i)
    all[i] = difference(Load(p + circle[i]), centre);
  return LargestOfNine(all);
}

// Scores of 16 pixels, 0 for those that are no corners.
Bytes ScoresAt(const std::uint8_t* p,
               const std::array<std::ptrdiff_t, kCircle>& circle,
               Bytes threshold) {
  const Bytes brighter =
      LargestArc(p, circle, threshold, [](Bytes a, Bytes b) { return Excess(a, b); });
  const Bytes darker =
      LargestArc(p, circle, threshold, [](Bytes a, Bytes b) { return Excess(b, a); });
  const Bytes largest = Max(brighter, darker);
  return largest > threshold ? largest - 1 : Bytes{};
}

// Of 16 scores those that are higher than the eight around them, the others 0.
Bytes HighestOf(const std::uint8_t* scores, int stride) {
  const Bytes centre = Load(scores);
  Bytes others = Max(Load(scores - 1), Load(scores + 1));
  for (const std::uint8_t* row : {scores - stride, scores + stride})
    others = Max(others, Max(Load(row), Max(Load(row - 1), Load(row + 1))));
  return centre > others ? centre : Bytes{};
}

}  // namespace

void FastCorners::FillScores(const ImageLevel& image, const cv::Rect& cell, int threshold) {
  stride_ = (cell.width + kLanes - 1) / kLanes * kLanes + 2;
  scores_.assign(static_cast<std::size_t>(stride_ * (cell.height + 2)), 0);
  const auto circle = CircleOf(image.step);
  const Bytes thresholds = static_cast<std::uint8_t>(threshold) + Bytes{};
  const int end = cell.x + cell.width, last_start = image.width - kRadius - kLanes;
  for (int y = 0; y < cell.height; ++y) {
    const std::uint8_t* const row =
        image.data + static_cast<std::ptrdiff_t>(cell.y + y) * image.step;
    for (int x = cell.x; x < end; x += kLanes) {
      const int start = std::min(x, last_start);
      const Bytes scores = ScoresAt(row + start, circle, thresholds);
      if (!IsAnyNotZero(scores)) continue;
      std::uint8_t lanes[kLanes];
      std::memcpy(lanes, &scores, sizeof(scores));
      std::copy(
          lanes + (x - start), lanes + std::min(kLanes, end - start), ScoresOfRow(y) + x - cell.x);
    }
  }
}

std::span<const FastCorner> FastCorners::Find(const ImageLevel& image,
                                              const cv::Rect& cell,
                                              int threshold) {
  FACET_CHECK(threshold >= 1 && threshold <= 255) << threshold;
  FACET_CHECK(image.width >= kMinWidth) << image.width;
  FACET_CHECK(cell.x >= kRadius && cell.y >= kRadius &&
              cell.x + cell.width + kRadius <= image.width &&
              cell.y + cell.height + kRadius <= image.height)
      << cell.x << ' ' << cell.y << ' ' << cell.width << " x " << cell.height;
  FillScores(image, cell, threshold);
  corners_.clear();
  for (int y = 0; y < cell.height; ++y) {
    const std::uint8_t* const scores = ScoresOfRow(y);
    for (int x = 0; x < cell.width; x += kLanes) {
      const Bytes highest = HighestOf(scores + x, stride_);
      std::uint64_t halves[2];
      std::memcpy(halves, &highest, sizeof(highest));
      for (const int first : {0, 8}) {
        for (std::uint64_t rest = halves[first / 8]; rest != 0;) {
          const int lane = std::countr_zero(rest) / 8;
          corners_.push_back(
              {cell.x + x + first + lane, cell.y + y, static_cast<std::uint8_t>(rest >> 8 * lane)});
          rest &= ~(std::uint64_t{255} << 8 * lane);
        }
      }
    }
  }
  return corners_;
}

}  // namespace facet
