// SPDX-License-Identifier: BSD-2-Clause
// What is about to leave the window.
#pragma once

#include <algorithm>
#include <vector>

#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// One flag per frame, landmark and plane.
struct MarginalizationPlan {
  std::vector<char> drop_frame;     ///< pose (and motion, if any) leave
  std::vector<char> drop_motion;    ///< velocity and biases leave, the pose stays
  std::vector<char> drop_landmark;  ///< leaves with all its observations and plane rows
  std::vector<char> drop_plane;     ///< leaves; rows and measurements of what stays go with it

  explicit MarginalizationPlan(const SlidingWindow& window)
      : drop_frame(window.frames.size(), 0),
        drop_motion(window.frames.size(), 0),
        drop_landmark(window.landmarks().size(), 0),
        drop_plane(window.planes.size(), 0) {}

  bool IsEmpty() const {
    const auto none = [](const std::vector<char>& flags) {
      return std::none_of(flags.begin(), flags.end(), [](char f) { return f != 0; });
    };
    return none(drop_frame) && none(drop_motion) && none(drop_landmark) && none(drop_plane);
  }

  bool Drops(Variable variable) const {
    const auto index = static_cast<std::size_t>(variable.index);
    switch (variable.kind) {
      case Variable::Kind::kPlane:
        return drop_plane[index] != 0;
      case Variable::Kind::kCalibration:
        return false;
      case Variable::Kind::kPose:
        return drop_frame[index] != 0;
      case Variable::Kind::kMotion:
        return drop_frame[index] != 0 || drop_motion[index] != 0;
    }
    return false;
  }
};

}  // namespace facet
