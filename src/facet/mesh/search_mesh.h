// SPDX-License-Identifier: BSD-2-Clause
// The horizon mesh after a keyframe as the search for planes gets it.
#pragma once

#include <array>
#include <vector>

#include "facet/base/types.h"
#include "facet/geometry/se3.h"

namespace facet {

struct SearchMesh {
  Timestamp t;
  SE3 T_WC;               ///< left camera of the keyframe
  double focal_px = 0;    ///< of that camera
  double baseline_m = 0;  ///< of the stereo pair

  std::vector<Vector3d> vertices;      ///< in W, as tracked or matched
  std::vector<LandmarkId> vertex_ids;  ///< one per vertex, ascending; see IsSupport
  std::vector<double> sigma_depth_m;   ///< one per vertex: 1-sigma of its distance from the camera
  /// Ids of the support points that this keyframe has matched: from the first to before the end.
  /// The other support ids are of corners that the estimator has, too, and of guesses.
  LandmarkId first_match, end_match;

  /// Faces that the mesh's own tests accepted, counter-clockwise seen by the camera: planes are
  /// sought among these.
  std::vector<std::array<int, 3>> faces;
  std::vector<char> may_vote;  ///< one per face: passed the strict limits
  std::vector<char> in_view;   ///< one per face: triangulated in this keyframe

  /// What planes may judge: every face of the horizon, then the triangles of this keyframe that the
  /// mesh's own tests rejected. Empty if nobody judges.
  std::vector<std::array<int, 3>> triangles;
  std::vector<Vector3d> shown_vertices;  ///< in W, as they are shown; as many as vertices
  /// Vertices from this one on are the support points that this keyframe carries.
  std::size_t first_carried = 0;

  /// Where vertex i is shown if planes change its distance from the camera by this factor. Only the
  /// support points that this keyframe carries move.
  Vector3d ShownWith(double depth_scale, std::size_t i) const {
    if (i < first_carried) return shown_vertices[i];
    return T_WC.p + depth_scale * (vertices[i] - T_WC.p);
  }
};

}  // namespace facet
