// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/plane_merge.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "facet/regularities/plane_gate.h"

namespace facet {

namespace {

constexpr double kMaxAngle = 1.5 * std::numbers::pi / 180;
constexpr double kMaxOffset_m = 0.02;
constexpr double kMaxChiSquare = 14.2;  // three sigmas, 3 degrees of freedom
constexpr double kMaxGap_m = 0.5;

void Merge(const MapSnapshot& map,
           KnownPlane& older,
           const KnownPlane& younger,
           PlaneAssignments& out) {
  for (const LandmarkEstimate& landmark : map.landmarks) {
    if (landmark.IsOn(younger.id) && !older.Has(landmark))
      out.joined.push_back({landmark.id, older.id, 2 * kMaxOffset_m});
  }
  // What the younger one knew goes over when it is marginalised.
  out.related.push_back({PlaneRelationKind::kCoplanar, older.id, younger.id});
  out.ended.push_back(younger.id);
  older.Absorb(younger, younger.estimate.plane_W);
}

}  // namespace

bool AreCoplanar(const KnownPlane& a, const KnownPlane& b, const SE3& T_WB) {
  if (!a.estimate.is_settled || !b.estimate.is_settled) return false;
  const Plane& plane_a = a.estimate.plane_W;
  const Plane& plane_b = b.estimate.plane_W;
  if (std::abs(plane_a.n.dot(plane_b.n)) < std::cos(kMaxAngle)) return false;
  const Vector3d middle_a = a.support.Centroid(plane_a), middle_b = b.support.Centroid(plane_b);
  return std::abs(plane_a.SignedDistance(middle_b)) <= kMaxOffset_m &&
         std::abs(plane_b.SignedDistance(middle_a)) <= kMaxOffset_m &&
         ChiSquare(a.estimate, b.estimate, middle_a, T_WB) <= kMaxChiSquare &&
         ChiSquare(a.estimate, b.estimate, middle_b, T_WB) <= kMaxChiSquare;
}

void MergeSameSurfaces(const MapSnapshot& map,
                       std::vector<KnownPlane>& planes,
                       PlaneAssignments& out) {
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (std::size_t j = planes.size(); j-- > i + 1;) {
      if (planes[i].IsTentative() || planes[j].IsTentative()) continue;
      if (!AreCoplanar(planes[i], planes[j], map.latest.T_WB)) continue;
      // Coplanar surfaces that are far apart stay two planes.
      if (!planes[i].support.IsNear(planes[j].support, planes[j].estimate.plane_W, kMaxGap_m))
        continue;
      if (planes[j].id < planes[i].id) std::swap(planes[i], planes[j]);
      Merge(map, planes[i], planes[j], out);
      planes.erase(planes.begin() + static_cast<std::ptrdiff_t>(j));
    }
  }
}

}  // namespace facet
