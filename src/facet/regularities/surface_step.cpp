// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/surface_step.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace facet {

namespace {

constexpr int kMinPoints = 10;  // on each side
constexpr double kMinStep_m = 0.03;
// Beyond what the best of all lines reaches on one plane, with 3 and many degrees of freedom.
constexpr double kMinFStatistic = 13;

struct Side {
  std::vector<Vector3d> points;
  std::vector<double> weights;

  void Add(const Vector3d& p, double weight) {
    points.push_back(p);
    weights.push_back(weight);
  }
  double TotalWeight() const { return std::accumulate(weights.begin(), weights.end(), 0.0); }
};

// Residuals of a plane that bridges two surfaces change their sign at the step: their running sum
// is farthest from zero there.
double LikeliestPosition(std::span<const Vector3d> points_W,
                         std::span<const double> weights,
                         const Plane& plane_W,
                         const Vector3d& direction_W) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < points_W.size(); ++i)
    order.emplace_back(direction_W.dot(points_W[i]), i);
  std::sort(order.begin(), order.end());
  double sum = 0, farthest = 0, position = order.front().first;
  for (std::size_t k = 0; k + 1 < order.size(); ++k) {
    const std::size_t i = order[k].second;
    sum += weights[i] * plane_W.SignedDistance(points_W[i]);
    if (std::abs(sum) <= farthest) continue;
    farthest = std::abs(sum);
    position = 0.5 * (order[k].first + order[k + 1].first);
  }
  return position;
}

bool IsStep(std::span<const Vector3d> points_W,
            std::span<const double> weights,
            const PlaneFit& fit,
            const SurfaceStep& step) {
  Side below, beyond;
  for (std::size_t i = 0; i < points_W.size(); ++i)
    (step.IsBeyond(points_W[i]) ? beyond : below).Add(points_W[i], weights[i]);
  if (std::min(below.points.size(), beyond.points.size()) < kMinPoints) return false;
  const PlaneFit a = FitPlane(below.points, below.weights);
  const PlaneFit b = FitPlane(beyond.points, beyond.weights);
  const double weight_a = below.TotalWeight(), weight_b = beyond.TotalWeight();
  const double apart =
      weight_a * a.thickness_m * a.thickness_m + weight_b * b.thickness_m * b.thickness_m;
  const double together = (weight_a + weight_b) * fit.thickness_m * fit.thickness_m;
  const double freedom = static_cast<double>(points_W.size()) - 6;
  if ((together - apart) / 3 < kMinFStatistic * apart / freedom) return false;

  // How far apart the two planes are where they meet, along the normal of both together.
  const Vector3d& n = fit.plane.n;
  const Vector3d at =
      fit.centroid + (step.position_m - step.direction_W.dot(fit.centroid)) * step.direction_W;
  const double jump =
      a.plane.SignedDistance(at) / a.plane.n.dot(n) - b.plane.SignedDistance(at) / b.plane.n.dot(n);
  return std::abs(jump) > kMinStep_m;
}

}  // namespace

std::optional<SurfaceStep> FindStep(std::span<const Vector3d> points_W,
                                    std::span<const double> weights,
                                    const PlaneFit& fit) {
  if (points_W.size() < 2 * kMinPoints) return std::nullopt;
  for (const Vector3d& direction : {fit.major_W, Vector3d(fit.plane.n.cross(fit.major_W))}) {
    const SurfaceStep step{direction, LikeliestPosition(points_W, weights, fit.plane, direction)};
    if (IsStep(points_W, weights, fit, step)) return step;
  }
  return std::nullopt;
}

}  // namespace facet
