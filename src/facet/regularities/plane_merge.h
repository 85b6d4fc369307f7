// SPDX-License-Identifier: BSD-2-Clause
// Second thoughts about planes that the estimator already has: two that are one surface.
#pragma once

#include <vector>

#include "facet/map/plane_assignments.h"
#include "facet/regularities/known_plane.h"

namespace facet {

struct AgreementLimits {
  double max_angle = 0, max_offset_m = 0;
};

/// Whether two planes agree, normals and the distances at the middle of each other's surface,
/// within the limits and three sigmas of what the camera's pose and the planes leave open. Two
/// sides of a thin wall never agree: normals point to where the surface was seen from.
bool Agree(const PlaneEstimate& a,
           const Vector3d& middle_a_W,
           const PlaneEstimate& b,
           const Vector3d& middle_b_W,
           const SE3& T_WB,
           const AgreementLimits& limits);

/// Whether both planes are known well and agree: normals within 1.5 deg, distances at the middle of
/// each other's surface within 2 cm, all of it within three sigmas of what the camera's pose and
/// the planes leave open.
bool AreCoplanar(const KnownPlane& a, const KnownPlane& b, const SE3& T_WB);

/// Of each two coplanar planes whose surfaces are less than about half a metre apart, the younger
/// one ends; its landmarks and its surface go to the older one.
void MergeSameSurfaces(const MapSnapshot& map,
                       std::vector<KnownPlane>& planes,
                       PlaneAssignments& out);

}  // namespace facet
