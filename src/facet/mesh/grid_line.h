// SPDX-License-Identifier: BSD-2-Clause
// Straight lines through a grid of blocks of voxels, for looking along them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "facet/base/types.h"
#include "facet/mesh/cube_map.h"

namespace facet {

/// A line through the grid in equal steps, in whole numbers: 2^-32 of a voxel, whose upper halves
/// are the voxels that it passes. Blocks are cubes of kBlockSide voxels a side.
template <int kBlockSide>
class GridLine {
 public:
  GridLine(const Vector3d& begin, const Vector3d& step)
      : begin_(begin), step_(step), at_(Fixed(begin)), per_step_(Fixed(step)) {
    for (int axis = 0; axis < 3; ++axis)
      inverse_[axis] = step[axis] == 0 ? 0 : 1 / step[axis];
  }

  CubeIndex Corner() const { return {Whole(at_[0]), Whole(at_[1]), Whole(at_[2])}; }

  void Advance() {
    for (int axis = 0; axis < 3; ++axis)
      at_[axis] += per_step_[axis];
    ++count_;
  }

  /// To the first place behind the block that holds the present one.
  void LeaveBlock(const CubeIndex& block) {
    constexpr int n = kBlockSide;
    const Vector3d low = n * Vector3d(block.x, block.y, block.z);
    double last = count_ + 2 * n;
    for (int axis = 0; axis < 3; ++axis) {
      const double border = step_[axis] > 0 ? low[axis] + n : low[axis];
      if (step_[axis] != 0) last = std::min(last, (border - begin_[axis]) * inverse_[axis]);
    }
    count_ = std::max(count_ + 1, static_cast<int>(last) + 1);
    at_ = Fixed(begin_ + count_ * step_);
  }

  int count() const { return count_; }  ///< steps so far

 private:
  using FixedPoint = std::array<std::int64_t, 3>;
  static std::int32_t Whole(std::int64_t x) { return static_cast<std::int32_t>(x >> 32); }
  static FixedPoint Fixed(const Vector3d& v) {
    constexpr double kUnit = 4294967296.0;
    return {static_cast<std::int64_t>(kUnit * v.x()),
            static_cast<std::int64_t>(kUnit * v.y()),
            static_cast<std::int64_t>(kUnit * v.z())};
  }

  Vector3d begin_, step_, inverse_;
  FixedPoint at_, per_step_;
  int count_ = 0;
};

}  // namespace facet
