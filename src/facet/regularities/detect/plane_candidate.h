// SPDX-License-Identifier: BSD-2-Clause
// A plane as one keyframe shows it, fitted to faces of the mesh.
#pragma once

#include <span>
#include <vector>

#include "facet/map/plane_record.h"
#include "facet/regularities/detect/surface_face.h"
#include "facet/regularities/regularity_options.h"

namespace facet {

struct PlaneCandidate {
  Plane plane_W;  ///< the normal points to where most of the surface was seen from
  Vector3d centroid_W = Vector3d::Zero();
  PlaneOrientation orientation = PlaneOrientation::kOblique;
  double area_m2 = 0;
  double length_scale = 1;  ///< mean of its vertices (far_surfaces.h)
  double thickness_m = 0;   ///< RMS distance of the vertices
  /// Covariance of the normal [rad^2, rank 2] and variance of n . centroid [m^2], camera given.
  Matrix3d normal_covariance = Matrix3d::Zero();
  double offset_variance_m2 = 0;
  std::vector<int> faces;  ///< into SurfaceFaces::faces, ascending
};

/// The faces of `pool` on the plane: all corners within three sigmas (at least 1 cm, at most
/// `max_distance_m`, far away more), the normal within 25 deg.
std::vector<int> FacesOnPlane(const SurfaceFaces& faces,
                              std::span<const int> pool,
                              const Plane& plane_W,
                              double max_distance_m);

/// [m^2]
double AreaOf(const SurfaceFaces& faces, std::span<const int> on_plane);

/// What these faces count for in the search (SurfaceFace::search_area_m2).
double SearchAreaOf(const SurfaceFaces& faces, std::span<const int> on_plane);

/// Least spread of the points of a plane with these faces [m]: less for what is near, more for what
/// is far away.
double MinExtent_m(const SurfaceFaces& faces,
                   std::span<const int> on_plane,
                   const DetectionOptions& options);

/// The faces of `pool` within half a metre (far away more) and 45 deg, which are all that a plane
/// fitted from `start` may have.
std::vector<int> FacesAround(const SurfaceFaces& faces,
                             std::span<const int> pool,
                             const Plane& start);

/// Fits a plane to `around`, which must be what FacesAround gives for the same `start` (ascending):
/// all three degrees of freedom, and judges it. Every connected piece large enough is a candidate
/// of its own: two tables of the same height are two planes, and so are two surfaces that a step
/// parts. Candidates that are too small, too thick or too narrow are left out, and so are those
/// that turned away from `start`.
std::vector<PlaneCandidate> FitCandidates(const SurfaceFaces& faces,
                                          const std::vector<int>& around,
                                          const Plane& start,
                                          double min_area_m2,
                                          const DetectionOptions& options);

/// Level, upright or neither: what leans more than max_lean_deg and three of its sigmas (along the
/// direction of the lean) is oblique.
PlaneOrientation OrientationOf(const Vector3d& n_W,
                               const Matrix3d& normal_covariance,
                               double max_lean_deg);

}  // namespace facet
