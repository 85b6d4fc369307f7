// SPDX-License-Identifier: BSD-2-Clause
// Levenberg-Marquardt on the window. Knows no geometry; see WindowSystem.
#pragma once

#include "facet/estimator/estimator_options.h"
#include "facet/estimator/solver/window_system.h"
#include "facet/estimator/window/window_values.h"

namespace facet {

struct SolveSummary {
  int iterations = 0;  ///< accepted steps
  /// Before the first and after the last step; the loss may have become narrower in between.
  double initial_cost = 0;
  double final_cost = 0;
  bool ok = false;         ///< false: the system could not be factorised at all
  bool converged = false;  ///< another step would gain next to nothing
};

class WindowSolver {
 public:
  /// Without `robust`, relations and the landmarks of pipeline SP weigh what they do by default.
  WindowSolver(const StereoRig& rig, const SolverOptions& options)
      : WindowSolver(rig, options, options.robust()) {}
  WindowSolver(const StereoRig& rig, const SolverOptions& options, const RobustOptions& robust)
      : system_(rig), options_(options), robust_(robust) {}

  void set_robust(const RobustOptions& robust) { robust_ = robust; }

  /// Minimises the window's cost in at most `max_iterations` steps. Moves frames and landmarks.
  SolveSummary Solve(SlidingWindow& window, int max_iterations);

  /// Marginal covariance of the newest frame (theta p v b_g b_a) at the last linearisation of
  /// Solve, without its damping.
  Matrix<15, 15> NewestFrameCovariance(const SlidingWindow& window);

  /// As of the last factorisation inside Solve.
  const WindowSystem& system() const { return system_; }

 private:
  RobustOptions RobustNow(const SlidingWindow& window);

  WindowSystem system_;
  SolverOptions options_;
  RobustOptions robust_;
  double factored_lambda_ = 0;  // of the last factorisation
  double lambda_ = 1e-6;
  WindowValues before_step_;
};

}  // namespace facet
