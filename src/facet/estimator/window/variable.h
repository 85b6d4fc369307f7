// SPDX-License-Identifier: BSD-2-Clause
// Names for the variables of the window.
#pragma once

#include "facet/camera/rig_columns.h"

namespace facet {

/// A variable as a block of columns of the normal equations: a plane (two tangent directions of its
/// normal, offset), the pose of a frame (theta p) or its motion (v b_g b_a), or the calibration (at
/// most one). Landmarks have no columns: each is eliminated as soon as its rows are there.
struct Variable {
  enum class Kind { kPlane, kCalibration, kPose, kMotion };

  Kind kind;
  int index;  ///< of the plane or frame in the window; 0 for the calibration

  bool operator==(const Variable&) const = default;

  static Variable Plane(int plane) { return {Kind::kPlane, plane}; }
  static Variable Calibration() { return {Kind::kCalibration, 0}; }
  static Variable Pose(int frame) { return {Kind::kPose, frame}; }
  static Variable Motion(int frame) { return {Kind::kMotion, frame}; }
};

/// Number of columns.
constexpr int SizeOf(Variable::Kind kind) {
  switch (kind) {
    case Variable::Kind::kPlane:
      return 3;
    case Variable::Kind::kCalibration:
      return kNumCalibration;
    case Variable::Kind::kPose:
      return 6;
    case Variable::Kind::kMotion:
      return 9;
  }
  return 0;
}

}  // namespace facet
