// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window_solver.h"

#include <algorithm>

namespace facet {

namespace {
constexpr double kMinLambda = 1e-9;
constexpr double kMaxLambda = 1e4;
}  // namespace

void WindowSolver::Save(const SlidingWindow& window) {
  saved_x_.clear();
  saved_lin_.clear();
  saved_delta_.clear();
  for (const WindowFrame& frame : window.frames) {
    saved_x_.push_back(frame.x);
    saved_lin_.push_back(frame.lin);
    saved_delta_.push_back(frame.delta);
  }
  saved_planes_ = window.planes;
  saved_landmarks_.clear();
  for (const WindowLandmark& landmark : window.landmarks()) {
    saved_landmarks_.emplace_back(landmark.bearing_H, landmark.inverse_distance);
  }
}

void WindowSolver::Restore(SlidingWindow& window) const {
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    window.frames[i].x = saved_x_[i];
    window.frames[i].lin = saved_lin_[i];
    window.frames[i].delta = saved_delta_[i];
  }
  window.planes = saved_planes_;
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    window.landmarks()[l].bearing_H = saved_landmarks_[l].first;
    window.landmarks()[l].inverse_distance = saved_landmarks_[l].second;
  }
}

SolveSummary WindowSolver::Solve(SlidingWindow& window, int max_iterations) {
  SolveSummary summary;
  lambda_ = kMinLambda;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    system_.Linearize(window, robust_);
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
      Save(window);
      system_.ApplyStep(window);
      const double new_cost = system_.Cost(window, robust_);
      if (new_cost <= cost) {
        accepted = true;
        summary.final_cost = new_cost;
        lambda_ = std::max(lambda_ * 0.1, kMinLambda);
        continue;
      }
      Restore(window);
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
  if (factored_lambda_ > kMinLambda && system_.Solve(window, kMinLambda)) {
    factored_lambda_ = kMinLambda;
  }
  return system_.NewestFrameCovariance();
}

}  // namespace facet
