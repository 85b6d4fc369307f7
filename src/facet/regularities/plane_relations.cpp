// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/plane_relations.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace facet {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kRightAngle = 0.5 * std::numbers::pi;

// 1-sigma of turns of the normal about the vertical, and of its lean, poses of the window given.
double SigmaInDirection(const PlaneEstimate& plane, const Vector3d& direction_W) {
  const Matrix3d covariance = plane.covariance.block<3, 3>(6, 6);
  return std::sqrt(std::max(direction_W.dot(covariance * direction_W), 0.0));
}

// Angle to the nearest multiple of 90 deg, and whether that is an even one (parallel).
std::pair<double, bool> HeadingDifference(const Vector3d& a, const Vector3d& b) {
  const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.x() * b.x() + a.y() * b.y());
  const double quarters = std::round(turn / kRightAngle);
  const bool is_parallel = static_cast<int>(quarters) % 2 == 0;
  return {turn - quarters * kRightAngle, is_parallel};
}

Vector3d Sideways(const Vector3d& n_W) {
  return Vector3d::UnitZ().cross(n_W).normalized();
}

}  // namespace

void PlaneRelations::Update(const std::vector<RelatedPlane>& planes,
                            std::vector<PlaneRelation>& out) {
  if (!options_.enabled) return;
  if (options_.gravity) {
    for (const RelatedPlane& plane : planes)
      RelateToGravity(plane, out);
  }
  if (options_.headings) RelateHeadings(planes, out);
}

void PlaneRelations::Forget(PlaneId plane) {
  std::erase_if(evidence_, [&](const auto& entry) {
    const auto& [a, b] = entry.first.second;
    return a == plane || b == plane;
  });
}

void PlaneRelations::Clear() {
  headings_.clear();
  evidence_.clear();
}

// True when the relation has held often enough and was not proposed before.
bool PlaneRelations::Weigh(const PlaneRelation& relation, double angle, double sigma) {
  const PlaneRelation key = relation.Canonical();
  Evidence& evidence = evidence_[{static_cast<int>(key.kind), {key.a, key.b}}];
  const bool holds =
      std::abs(angle) <= std::min(options_.max_angle_deg * kDegree, 3 * std::hypot(sigma, kDegree));
  evidence.num_keyframes = holds ? evidence.num_keyframes + 1 : 0;
  if (evidence.is_proposed || evidence.num_keyframes < options_.min_keyframes) return false;
  evidence.is_proposed = true;
  return true;
}

void PlaneRelations::RelateToGravity(const RelatedPlane& plane, std::vector<PlaneRelation>& out) {
  const PlaneEstimate& estimate = *plane.estimate;
  const Vector3d& n = estimate.plane_W.n;
  if (plane.orientation == PlaneOrientation::kOblique || !estimate.is_settled) return;
  const bool is_level = plane.orientation == PlaneOrientation::kHorizontal;
  const PlaneRelation relation = {
      is_level ? PlaneRelationKind::kHorizontal : PlaneRelationKind::kVertical, estimate.id};
  const double lean = is_level ? std::asin(std::min(1.0, n.head<2>().norm())) : std::asin(n.z());
  const Vector3d up = Vector3d::UnitZ() - n.z() * n;
  const double sigma = up.norm() > 1e-6 ? SigmaInDirection(estimate, up.normalized()) : kDegree;
  if (Weigh(relation, lean, sigma)) out.push_back(relation);
}

void PlaneRelations::RelateHeadings(const std::vector<RelatedPlane>& planes,
                                    std::vector<PlaneRelation>& out) {
  const auto find = [&](PlaneId id) {
    return std::find_if(planes.begin(), planes.end(), [&](const RelatedPlane& plane) {
      return plane.estimate->id == id;
    });
  };
  std::erase_if(headings_, [&](PlaneId id) { return find(id) == planes.end(); });
  for (const RelatedPlane& wall : planes) {
    const PlaneEstimate& estimate = *wall.estimate;
    if (wall.orientation != PlaneOrientation::kVertical || !estimate.is_settled ||
        wall.area_m2 < options_.min_area_m2) {
      continue;
    }
    bool has_heading = false;
    for (const PlaneId id : headings_) {
      const PlaneEstimate& base = *find(id)->estimate;
      const auto [angle, is_parallel] = HeadingDifference(base.plane_W.n, estimate.plane_W.n);
      if (std::abs(angle) > options_.new_heading_deg * kDegree) continue;
      has_heading = true;
      if (id == estimate.id) break;
      const PlaneRelation relation = {
          is_parallel ? PlaneRelationKind::kHeadingParallel : PlaneRelationKind::kHeadingOrthogonal,
          id,
          estimate.id};
      const double sigma = std::hypot(SigmaInDirection(estimate, Sideways(estimate.plane_W.n)),
                                      SigmaInDirection(base, Sideways(base.plane_W.n)));
      if (Weigh(relation, angle, sigma)) out.push_back(relation);
      break;
    }
    if (!has_heading) headings_.push_back(estimate.id);
  }
}

}  // namespace facet
