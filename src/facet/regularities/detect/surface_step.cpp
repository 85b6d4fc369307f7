// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/surface_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace facet {

namespace {

constexpr std::size_t kMinPoints = 10;  // on each side
constexpr std::size_t kMinShare = 6;    // a sixth of all points on each side
constexpr double kMinStep_m = 0.03;
// Far beyond what the best of all cuts reaches on one plane, with 2 and many degrees of freedom.
constexpr double kMinFStatistic = 15;

// Sums from which the line through weighted (t, r) and its squared residuals follow.
struct LineSums {
  double w = 0, wt = 0, wr = 0, wtt = 0, wtr = 0, wrr = 0;

  void Add(double t, double r, double weight) {
    w += weight;
    wt += weight * t;
    wr += weight * r;
    wtt += weight * t * t;
    wtr += weight * t * r;
    wrr += weight * r * r;
  }
  LineSums operator-(const LineSums& other) const {
    return {w - other.w,
            wt - other.wt,
            wr - other.wr,
            wtt - other.wtt,
            wtr - other.wtr,
            wrr - other.wrr};
  }
  double Slope() const {
    const double tt = wtt - wt * wt / w;
    return tt > 1e-12 * wtt ? (wtr - wt * wr / w) / tt : 0;
  }
  double Residual() const { return wrr - wr * wr / w - Slope() * (wtr - wt * wr / w); }
  double At(double t) const { return wr / w + Slope() * (t - wt / w); }
};

// Cuts the points across one direction where a line on each side fits their distances best.
std::optional<SurfaceStep> FindStepAlong(std::span<const Vector3d> points_W,
                                         std::span<const double> weights,
                                         const PlaneFit& fit,
                                         const Vector3d& direction_W,
                                         double min_step_m) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < points_W.size(); ++i)
    order.emplace_back(direction_W.dot(points_W[i] - fit.centroid), i);
  std::sort(order.begin(), order.end());
  std::vector<LineSums> below(order.size());
  LineSums all;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto [t, i] = order[k];
    all.Add(t, fit.plane.SignedDistance(points_W[i]), weights[i]);
    below[k] = all;
  }
  const std::size_t margin = std::max(kMinPoints, order.size() / kMinShare);
  std::size_t best = 0;
  double apart = std::numeric_limits<double>::infinity();
  for (std::size_t k = margin - 1; k + margin < order.size(); ++k) {
    const double residual = below[k].Residual() + (all - below[k]).Residual();
    if (residual >= apart) continue;
    apart = residual;
    best = k;
  }
  const double freedom = static_cast<double>(order.size()) - 4;
  if (!((all.Residual() - apart) / 2 > kMinFStatistic * apart / freedom)) return std::nullopt;
  const double t = 0.5 * (order[best].first + order[best + 1].first);
  const double step = (all - below[best]).At(t) - below[best].At(t);
  if (std::abs(step) < min_step_m) return std::nullopt;
  return SurfaceStep{direction_W, direction_W.dot(fit.centroid) + t};
}

}  // namespace

std::optional<SurfaceStep> FindStep(std::span<const Vector3d> points_W,
                                    std::span<const double> weights,
                                    const PlaneFit& fit,
                                    double length_scale) {
  if (points_W.size() < 2 * kMinPoints) return std::nullopt;
  const double min_step_m = length_scale * kMinStep_m;
  const Vector3d minor_W = fit.plane.n.cross(fit.major_W);
  const auto step = FindStepAlong(points_W, weights, fit, fit.major_W, min_step_m);
  return step ? step : FindStepAlong(points_W, weights, fit, minor_W, min_step_m);
}

}  // namespace facet
