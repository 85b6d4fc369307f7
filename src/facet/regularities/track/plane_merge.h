// SPDX-License-Identifier: BSD-2-Clause
// Merges planes of the estimator that turn out to be one surface.
#pragma once

#include <vector>

#include "facet/map/plane_assignments.h"
#include "facet/regularities/track/tracked_plane.h"

namespace facet {

struct AgreementLimits {
  double max_angle = 0, max_offset_m = 0;
};

/// Whether two planes agree in their normals and in their distances at the centroid of each other's
/// extent, within the limits and within three sigmas of their covariances. The two sides of a thin
/// wall never agree: normals point to where the surface was seen from.
bool Agree(const PlaneEstimate& a,
           const Vector3d& middle_a_W,
           const PlaneEstimate& b,
           const Vector3d& middle_b_W,
           const SE3& T_WB,
           const AgreementLimits& limits);

/// Whether both planes are persistent and agree: normals within 1.5 deg, distances at the centroid
/// of each other's extent within 2 cm, both within three sigmas of their covariances.
bool AreCoplanar(const TrackedPlane& a, const TrackedPlane& b, const SE3& T_WB);

/// Merges each two coplanar planes whose extents are less than about half a metre apart: the
/// younger one ends, its landmarks and its extent go to the older one.
void MergeSameSurfaces(const MapSnapshot& map,
                       std::vector<TrackedPlane>& planes,
                       PlaneAssignments& out);

}  // namespace facet
