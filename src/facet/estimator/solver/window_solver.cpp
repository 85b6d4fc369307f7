// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/window_solver.h"

#include <algorithm>

namespace facet {

namespace {
constexpr double kMinLambda = 1e-9;
constexpr double kMaxLambda = 1e4;
}  // namespace

// As long as the newest frame is far from where it belongs (a poor prediction, the first estimate
// of a start) everything that it sees would look like an outlier.
RobustOptions WindowSolver::RobustNow(const SlidingWindow& window) {
  RobustOptions robust = robust_;
  robust.reprojection_width =
      std::max(robust.reprojection_width, options_.loss_width * system_.NewestError(window));
  return robust;
}

SolveSummary WindowSolver::Solve(SlidingWindow& window, int max_iterations) {
  SolveSummary summary;
  lambda_ = kMinLambda;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const RobustOptions robust = RobustNow(window);
    system_.Linearize(window, robust);
    const double cost = system_.cost();
    if (iteration == 0) summary.initial_cost = summary.final_cost = cost;

    bool accepted = false;
    while (!accepted && lambda_ <= kMaxLambda) {
      factored_lambda_ = lambda_;
      if (!system_.Solve(window, lambda_)) {
        lambda_ = std::max(lambda_ * 10, 1e-6);
        continue;
      }
      summary.ok = true;
      before_step_.Save(window);
      system_.ApplyStep(window);
      const double new_cost = system_.Cost(window, robust);
      if (new_cost <= cost) {
        accepted = true;
        summary.final_cost = new_cost;
        lambda_ = std::max(lambda_ * 0.1, kMinLambda);
        continue;
      }
      before_step_.Restore(window);
      // With first-estimate Jacobians the gradient is slightly off: an uphill step this small is
      // the end.
      if (new_cost - cost < options_.min_cost_decrease) {
        summary.converged = true;
        return summary;
      }
      lambda_ = std::max(lambda_ * 10, 1e-6);
    }
    if (!accepted) break;
    ++summary.iterations;
    if (cost - summary.final_cost < options_.min_cost_decrease) {
      summary.converged = true;
      break;
    }
  }
  return summary;
}

Matrix<15, 15> WindowSolver::NewestFrameCovariance(const SlidingWindow& window) {
  // Damping is no information: it must not be in the factor.
  if (factored_lambda_ > kMinLambda) {
    if (system_.Solve(window, kMinLambda)) {
      factored_lambda_ = kMinLambda;
    } else {
      system_.Solve(window, factored_lambda_);  // the failure has spoiled that factor
    }
  }
  return system_.NewestFrameCovariance();
}

}  // namespace facet
