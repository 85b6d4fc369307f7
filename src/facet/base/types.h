// SPDX-License-Identifier: BSD-2-Clause
// The words that every module uses: time, ids, small matrix types.
#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace facet {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;
template <int R, int C>
using Matrix = Eigen::Matrix<double, R, C>;
template <int N>
using Vector = Eigen::Matrix<double, N, 1>;

/// A span of time in integer nanoseconds.
struct Duration {
  std::int64_t ns = 0;
  auto operator<=>(const Duration&) const = default;
};

/// A moment in integer nanoseconds; the epoch is the recording's own.
struct Timestamp {
  std::int64_t ns = 0;
  auto operator<=>(const Timestamp&) const = default;
};

/// Sums and differences beyond what 64 bits hold stop at the end: damaged stamps may be anything.
inline std::int64_t SaturatedSum(std::int64_t a, std::int64_t b) {
  std::int64_t sum = 0;
  if (!__builtin_add_overflow(a, b, &sum)) return sum;
  return b < 0 ? std::numeric_limits<std::int64_t>::min()
               : std::numeric_limits<std::int64_t>::max();
}
inline std::int64_t SaturatedDifference(std::int64_t a, std::int64_t b) {
  std::int64_t difference = 0;
  if (!__builtin_sub_overflow(a, b, &difference)) return difference;
  return b > 0 ? std::numeric_limits<std::int64_t>::min()
               : std::numeric_limits<std::int64_t>::max();
}

inline Duration operator-(Timestamp a, Timestamp b) {
  return {SaturatedDifference(a.ns, b.ns)};
}
inline Timestamp operator+(Timestamp t, Duration d) {
  return {SaturatedSum(t.ns, d.ns)};
}
inline Timestamp operator-(Timestamp t, Duration d) {
  return {SaturatedDifference(t.ns, d.ns)};
}
inline Duration operator+(Duration a, Duration b) {
  return {SaturatedSum(a.ns, b.ns)};
}

/// Only spans of time become floating point; an absolute stamp would lose digits.
inline double ToSeconds(Duration d) {
  return static_cast<double>(d.ns) * 1e-9;
}
/// The longest span there is for more than fits, none for what is no number.
inline Duration FromSeconds(double s) {
  constexpr double kMax_s = 9.2e9;
  if (std::isnan(s)) return {};
  return {std::llround(std::min(std::max(s, -kMax_s), kMax_s) * 1e9)};
}

/// An integer that cannot be mixed up with another kind of id; negative means "none".
template <class Tag>
struct Id {
  std::int64_t value = -1;
  auto operator<=>(const Id&) const = default;
  bool IsValid() const { return value >= 0; }
};

using LandmarkId = Id<struct LandmarkTag>;
using FrameId = Id<struct FrameTag>;
using PlaneId = Id<struct PlaneTag>;

}  // namespace facet

template <class Tag>
struct std::hash<facet::Id<Tag>> {
  std::size_t operator()(facet::Id<Tag> id) const noexcept {
    return std::hash<std::int64_t>()(id.value);
  }
};
