// SPDX-License-Identifier: BSD-2-Clause
// Which columns of the normal equations belong to which variable of the window.
#pragma once

#include <vector>

#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// Planes come first, then the calibration, then all poses, then the motion of the newest frame:
/// these columns are dense. The other motions follow, which are eliminated before (docs/math.md,
/// section 4.3).
struct StateLayout {
  std::vector<int> plane_column;   ///< by plane index
  int calibration_column = -1;     ///< -1 if it is not a variable, or held
  std::vector<int> pose_column;    ///< by frame index
  std::vector<int> motion_column;  ///< by frame index, -1 without motion
  int dim = 0;
  int dense_dim = 0;  ///< columns of planes, calibration, poses and the newest motion

  int ColumnOf(Variable variable) const {
    switch (variable.kind) {
      case Variable::Kind::kPlane:
        return plane_column[static_cast<std::size_t>(variable.index)];
      case Variable::Kind::kCalibration:
        return calibration_column;
      case Variable::Kind::kPose:
        return pose_column[static_cast<std::size_t>(variable.index)];
      case Variable::Kind::kMotion:
        return motion_column[static_cast<std::size_t>(variable.index)];
    }
    return -1;
  }
};

/// Whether a step may move the calibration, if it is a variable at all.
enum class CalibrationStep { kFree, kHeld };

StateLayout MakeLayout(const SlidingWindow& window,
                       CalibrationStep calibration_step = CalibrationStep::kFree);

/// A set of variables of one window. Not thread-safe: keeps its storage.
class VariableSet {
 public:
  /// Empty, for a window of this size.
  void Clear(std::size_t num_frames, std::size_t num_planes) {
    num_frames_ = num_frames;
    is_in_.assign(2 * num_frames + num_planes + 1, 0);
  }
  void Insert(Variable variable) { is_in_[Place(variable)] = 1; }
  void Insert(const VariableSet& other) {
    for (std::size_t k = 0; k < is_in_.size(); ++k)
      is_in_[k] |= other.is_in_[k];
  }
  bool Contains(Variable variable) const { return is_in_[Place(variable)] != 0; }

 private:
  std::size_t Place(Variable variable) const {
    const auto index = static_cast<std::size_t>(variable.index);
    if (variable.kind == Variable::Kind::kCalibration) return is_in_.size() - 1;
    if (variable.kind == Variable::Kind::kPlane) return 2 * num_frames_ + index;
    return 2 * index + (variable.kind == Variable::Kind::kMotion ? 1 : 0);
  }

  std::size_t num_frames_ = 0;
  std::vector<char> is_in_;
};

}  // namespace facet
