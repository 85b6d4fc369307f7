// SPDX-License-Identifier: BSD-2-Clause
// Names for the variables of the window.
#pragma once

namespace facet {

/// A variable as a block of columns of the normal equations: a plane (two tangent directions of its
/// normal, offset), the pose of a frame (theta p) or its motion (v b_g b_a). Landmarks have no
/// columns: each is eliminated as soon as its rows are there.
struct Variable {
  enum class Kind { kPlane, kPose, kMotion };

  Kind kind;
  int index;  ///< of the plane or frame in the window

  bool operator==(const Variable&) const = default;

  static Variable Plane(int plane) { return {Kind::kPlane, plane}; }
  static Variable Pose(int frame) { return {Kind::kPose, frame}; }
  static Variable Motion(int frame) { return {Kind::kMotion, frame}; }
};

/// Number of columns.
constexpr int SizeOf(Variable::Kind kind) {
  return kind == Variable::Kind::kMotion ? 9 : kind == Variable::Kind::kPose ? 6 : 3;
}

}  // namespace facet
