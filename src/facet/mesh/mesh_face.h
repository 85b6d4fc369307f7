// SPDX-License-Identifier: BSD-2-Clause
// The faces of the horizon mesh, and what is left of one when it leaves the horizon.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "facet/base/types.h"

namespace facet {

struct MeshFace {
  /// Vertex indices, ascending.
  std::array<int, 3> corners{};
  /// Whether the corners must be read backwards to go counter-clockwise seen by the camera.
  bool is_flipped = false;
  bool may_vote = false;     ///< passed the strict limits: may vote for planes
  bool in_view = false;      ///< one of the newest keyframe's own faces
  int num_seen_through = 0;  ///< what keyframes have seen behind it
  int plane_id = -1;
  bool by_plane = false;   ///< rejected by the tests, shown because a known plane says so
  bool is_hidden = false;  ///< known planes say that there is no surface
  /// For each side, by the corner opposite to it: whether the newest view that has the face shows
  /// nothing beyond.
  std::array<bool, 3> is_boundary{};
  /// The camera of the newest keyframe whose triangulation has it.
  Eigen::Vector3f eye_W = Eigen::Vector3f::Zero();

  /// Corners counter-clockwise as the camera saw them; the normal points to the camera.
  std::array<int, 3> CounterClockwise() const {
    if (is_flipped) return {corners[0], corners[2], corners[1]};
    return corners;
  }
};

/// The order in which the horizon mesh keeps its faces.
inline bool ComesBefore(const MeshFace& a, const MeshFace& b) {
  return a.corners < b.corners;
}

/// A face that left the horizon, with its last estimate, without having been proven wrong.
struct ExpiredFace {
  std::array<Vector3d, 3> p_W;  ///< counter-clockwise seen by the camera
  std::array<std::uint8_t, 3> intensity{};
  double sigma_depth_m = 0;  ///< mean of the vertices
  int plane_id = -1;
  std::optional<Vector3d> eye_W;  ///< the camera that saw it last, if known
  /// For each side, by the corner p_W opposite to it: whether no surface was seen beyond. Faces
  /// that newer ones cover have no boundary, because the newer ones say what lies beyond.
  std::array<bool, 3> is_boundary{};
};

}  // namespace facet
