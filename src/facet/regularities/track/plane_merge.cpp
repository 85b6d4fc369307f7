// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/plane_merge.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "facet/geometry/angles.h"
#include "facet/regularities/track/plane_gate.h"

namespace facet {

namespace {

constexpr AgreementLimits kCoplanar = {1.5 * kDegree, 0.02};
constexpr double kMaxMergeChiSquare = 14.2;  // three sigmas, 3 degrees of freedom

void Merge(const MapSnapshot& map,
           TrackedPlane& older,
           const TrackedPlane& younger,
           PlaneAssignments& out) {
  for (const LandmarkEstimate& landmark : map.landmarks) {
    if (landmark.IsOn(younger.id) && !older.Has(landmark))
      out.attached.push_back({landmark.id, older.id, 2 * kCoplanar.max_offset_m});
  }
  // If the prior knows the younger one, that goes over when it is marginalised.
  out.relations.push_back({PlaneRelationKind::kCoplanar, older.id, younger.id});
  out.retired.push_back(younger.id);
  older.Merge(younger, younger.estimate.plane_W);
}

}  // namespace

bool Agree(const PlaneEstimate& a,
           const Vector3d& middle_a_W,
           const PlaneEstimate& b,
           const Vector3d& middle_b_W,
           const SE3& T_WB,
           const AgreementLimits& limits) {
  return AngleBetween(a.plane_W.n, b.plane_W.n) <= limits.max_angle &&
         std::abs(a.plane_W.SignedDistance(middle_b_W)) <= limits.max_offset_m &&
         std::abs(b.plane_W.SignedDistance(middle_a_W)) <= limits.max_offset_m &&
         ChiSquare(a, b, middle_a_W, T_WB) <= kMaxMergeChiSquare &&
         ChiSquare(a, b, middle_b_W, T_WB) <= kMaxMergeChiSquare;
}

bool AreCoplanar(const TrackedPlane& a, const TrackedPlane& b, const SE3& T_WB) {
  return a.estimate.is_persistent && b.estimate.is_persistent &&
         Agree(a.estimate,
               a.extent.Centroid(a.estimate.plane_W),
               b.estimate,
               b.extent.Centroid(b.estimate.plane_W),
               T_WB,
               kCoplanar);
}

void MergeSameSurfaces(const MapSnapshot& map,
                       std::vector<TrackedPlane>& planes,
                       PlaneAssignments& out) {
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (std::size_t j = planes.size(); j-- > i + 1;) {
      if (planes[i].IsTentative() || planes[j].IsTentative()) continue;
      if (!AreCoplanar(planes[i], planes[j], map.latest.T_WB)) continue;
      // Coplanar surfaces that are far apart stay two planes.
      if (!planes[i].extent.IsNear(planes[j].extent, planes[j].estimate.plane_W, kPlaneGrowth_m))
        continue;
      if (planes[j].id < planes[i].id) std::swap(planes[i], planes[j]);
      Merge(map, planes[i], planes[j], out);
      planes.erase(planes.begin() + static_cast<std::ptrdiff_t>(j));
    }
  }
}

}  // namespace facet
