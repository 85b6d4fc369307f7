// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/constrain/plane_relations.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>

#include "facet/geometry/angles.h"

namespace facet {

namespace {

constexpr double kRightAngle = 0.5 * std::numbers::pi;

// Planes that are off by more are not related, but a wall that is off by more than the second has a
// heading of its own.
constexpr double kMaxAngle = 3 * kDegree, kNewHeading = 8 * kDegree;
// What is level or upright leans by at most this. The estimator gives such a relation up beyond
// four of its sigmas, which with its usual 0.3 deg is the same, and a relation is proposed once.
constexpr double kMaxLean = 1.2 * kDegree;
constexpr double kMaxHeight_m = 0.02;  // the same for heights
// A relation must have held in so many keyframes in a row.
constexpr int kMinKeyframes = 5;

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

void PlaneRelations::Update(const Planes& planes, std::vector<PlaneRelation>& out) {
  if (!options_.enabled) return;
  Planes persistent;
  std::copy_if(planes.begin(), planes.end(), std::back_inserter(persistent), [](const auto& plane) {
    return plane.estimate->is_persistent;
  });
  std::stable_sort(persistent.begin(), persistent.end(), [](const auto& a, const auto& b) {
    return a.area_m2 > b.area_m2;
  });
  if (options_.gravity) {
    for (const RelatedPlane& plane : persistent)
      RelateToGravity(plane, out);
  }
  const auto star = [&](PlaneOrientation orientation, auto compare, std::vector<PlaneId>& middles) {
    RelateStar(persistent, orientation, std::bind_front(compare, this), middles, out);
  };
  using enum PlaneOrientation;
  if (options_.headings) star(kVertical, &PlaneRelations::CompareHeadings, headings_);
  if (options_.same_height) star(kHorizontal, &PlaneRelations::CompareHeights, heights_);
  if (options_.slopes) star(kOblique, &PlaneRelations::CompareSlopes, slopes_);
}

void PlaneRelations::Forget(PlaneId plane) {
  std::erase_if(evidence_, [&](const auto& entry) {
    const auto& [a, b] = entry.first.second;
    return a == plane || b == plane;
  });
}

void PlaneRelations::Clear() {
  headings_.clear();
  heights_.clear();
  slopes_.clear();
  evidence_.clear();
}

double PlaneRelations::AngleLimit(double sigma) const {
  return std::min(kMaxAngle, 3 * std::hypot(sigma, kDegree));
}

// True when the relation has held often enough and was not proposed before.
bool PlaneRelations::Weigh(const PlaneRelation& relation, double difference, double limit) {
  const PlaneRelation key = relation.Canonical();
  Evidence& evidence = evidence_[{static_cast<int>(key.kind), {key.a, key.b}}];
  evidence.num_keyframes = std::abs(difference) <= limit ? evidence.num_keyframes + 1 : 0;
  if (evidence.is_proposed || evidence.num_keyframes < kMinKeyframes) return false;
  evidence.is_proposed = true;
  return true;
}

void PlaneRelations::RelateToGravity(const RelatedPlane& plane, std::vector<PlaneRelation>& out) {
  const PlaneEstimate& estimate = *plane.estimate;
  const Vector3d& n = estimate.plane_W.n;
  if (plane.orientation == PlaneOrientation::kOblique) return;
  const bool is_level = plane.orientation == PlaneOrientation::kHorizontal;
  const PlaneRelation relation = {
      is_level ? PlaneRelationKind::kHorizontal : PlaneRelationKind::kVertical, estimate.id};
  const double lean = is_level ? std::asin(std::min(1.0, n.head<2>().norm())) : std::asin(n.z());
  const Vector3d up = Vector3d::UnitZ() - n.z() * n;
  const double sigma = up.norm() > 1e-6 ? SigmaInDirection(estimate, up.normalized()) : kDegree;
  if (Weigh(relation, lean, std::max(kMaxLean, std::min(kMaxAngle, 3 * sigma))))
    out.push_back(relation);
}

// Largest first: a plane that is of no star yet becomes the middle of one.
template <class Compare>
void PlaneRelations::RelateStar(const Planes& planes,
                                PlaneOrientation orientation,
                                const Compare& compare,
                                std::vector<PlaneId>& middles,
                                std::vector<PlaneRelation>& out) {
  const auto find = [&](PlaneId id) {
    return std::find_if(planes.begin(), planes.end(), [&](const RelatedPlane& plane) {
      return plane.estimate->id == id;
    });
  };
  std::erase_if(middles, [&](PlaneId id) {  // gone, or found to lean
    const auto middle = find(id);
    return middle == planes.end() || middle->orientation != orientation;
  });
  for (const RelatedPlane& plane : planes) {
    const PlaneId id = plane.estimate->id;
    if (plane.orientation != orientation || plane.area_m2 < options_.min_area_m2) continue;
    bool is_of_a_star = false;
    for (const PlaneId middle : middles) {
      const std::optional<Difference> difference = compare(*find(middle), plane);
      if (!difference) continue;
      is_of_a_star = true;
      const PlaneRelation relation = {difference->kind, middle, id};
      if (middle != id && Weigh(relation, difference->value, difference->limit))
        out.push_back(relation);
      break;
    }
    if (!is_of_a_star) middles.push_back(id);
  }
}

std::optional<PlaneRelations::Difference> PlaneRelations::CompareHeadings(
    const RelatedPlane& a, const RelatedPlane& b) const {
  const Vector3d &n_a = a.estimate->plane_W.n, &n_b = b.estimate->plane_W.n;
  const auto [angle, is_parallel] = HeadingDifference(n_a, n_b);
  if (std::abs(angle) > kNewHeading) return std::nullopt;
  using enum PlaneRelationKind;
  const double sigma = std::hypot(SigmaInDirection(*a.estimate, Sideways(n_a)),
                                  SigmaInDirection(*b.estimate, Sideways(n_b)));
  return Difference{is_parallel ? kHeadingParallel : kHeadingOrthogonal, angle, AngleLimit(sigma)};
}

std::optional<PlaneRelations::Difference> PlaneRelations::CompareHeights(
    const RelatedPlane& a, const RelatedPlane& b) const {
  const Vector3d &n_a = a.estimate->plane_W.n, &n_b = b.estimate->plane_W.n;
  const double height_m = b.centroid_W.z() - a.centroid_W.z();
  // The underside of a shelf is not parallel to its top.
  const bool is_parallel = AngleBetween(n_a, n_b) <= kMaxAngle;
  if (!is_parallel || std::abs(height_m) > kMaxHeight_m) return std::nullopt;
  const double variance = a.estimate->covariance(9, 9) + b.estimate->covariance(9, 9);
  return Difference{PlaneRelationKind::kCoplanar, height_m, 3 * std::sqrt(variance)};
}

std::optional<PlaneRelations::Difference> PlaneRelations::CompareSlopes(
    const RelatedPlane& a, const RelatedPlane& b) const {
  const Vector3d &n_a = a.estimate->plane_W.n, &n_b = b.estimate->plane_W.n;
  const double angle = AngleBetween(n_a, n_b);
  const double from_parallel = std::min(angle, std::numbers::pi - angle);
  const double from_right_angle = kRightAngle - from_parallel;
  const bool is_parallel = from_parallel < from_right_angle;
  const double off = is_parallel ? from_parallel : from_right_angle;
  if (off > kNewHeading) return std::nullopt;
  const auto sigma = [](const PlaneEstimate& plane) {  // mean of both directions
    return std::sqrt(std::max(plane.covariance.block<3, 3>(6, 6).trace() / 2, 0.0));
  };
  using enum PlaneRelationKind;
  return Difference{is_parallel ? kParallel : kOrthogonal,
                    off,
                    AngleLimit(std::hypot(sigma(*a.estimate), sigma(*b.estimate)))};
}

}  // namespace facet
