// SPDX-License-Identifier: BSD-2-Clause
// Doubles that a processor multiplies and adds several at a time. Every number has its own lane and
// the same operations in the same order however many lanes there are, so the results have the same
// bits on every instruction set.
#pragma once

#include <cstring>

namespace facet {

template <int kLanes>
struct LaneType {
  typedef double Type __attribute__((vector_size(8 * kLanes)));  // NOLINT: g++ needs a typedef
};
template <int kLanes>
using Lanes = typename LaneType<kLanes>::Type;

template <int kLanes>
[[gnu::always_inline]] inline Lanes<kLanes> Load(const double* from) {
  Lanes<kLanes> lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}

template <int kLanes>
[[gnu::always_inline]] inline void Store(const Lanes<kLanes>& lanes, double* to) {
  std::memcpy(to, &lanes, sizeof(lanes));
}

template <int kLanes>
[[gnu::always_inline]] inline Lanes<kLanes> AllOf(double value) {
  Lanes<kLanes> lanes;
  for (int i = 0; i < kLanes; ++i)
    lanes[i] = value;
  return lanes;
}

/// Calls f.template operator()<n>(i) for numbers i to i + n - 1, from `first` (rounded down to a
/// whole step) to kSize, which is even: kLanes at a time, and what is left two at a time.
template <int kLanes, int kSize, class Function>
inline void OverLanes(int first, const Function& f) {
  static_assert(kSize % 2 == 0 && kLanes % 2 == 0);
  constexpr int kWhole = kSize / kLanes * kLanes;
  int i = first / kLanes * kLanes;
  for (; i < kWhole; i += kLanes)
    f.template operator()<kLanes>(i);
  for (; i < kSize; i += 2)
    f.template operator()<2>(i);
}

}  // namespace facet
