// SPDX-License-Identifier: BSD-2-Clause
// Levenberg-Marquardt on the window. Knows no geometry: it goes round linearise, reduce, step.
#pragma once

#include <optional>
#include <vector>

#include "facet/estimator/solver/covariance.h"
#include "facet/estimator/window/window_values.h"

namespace facet {

struct SolveSummary {
  int iterations = 0;  ///< accepted steps
  /// Before the first and after the last step; the loss may have become narrower in between.
  std::optional<double> initial_cost;
  double final_cost = 0;
  bool ok = false;         ///< false: the system could not be factorised at all
  bool converged = false;  ///< another step would gain next to nothing
};

/// Not thread-safe.
class WindowSolver {
 public:
  WindowSolver(const StereoRig& rig, const SolverOptions& options)
      : options_(options), geometry_(rig) {}

  /// Minimises the window's cost in at most `max_iterations` steps. Moves frames, planes, landmarks
  /// and the calibration. While the newest frame is far from where it belongs, the loss of
  /// reprojections is wider than `noise` says, the calibration is held, and, unless
  /// `max_iterations` is 1, a few more steps may be taken.
  SolveSummary Solve(SlidingWindow& window, const FactorNoise& noise, int max_iterations);

  /// Of the window of the last Solve, at its last linearisation and without its damping: theta p v
  /// b_g b_a of the newest frame.
  Matrix<15, 15> NewestFrameCovariance();

  /// Of the same window as it was factorised last; see covariance.h.
  std::vector<Matrix<9, 9>> PlaneCovariances() const {
    return facet::PlaneCovariances(reduced_, linear_.layout());
  }
  ClockCovariance NewestFrameWithClock() const {
    return facet::NewestFrameWithClock(reduced_, linear_.layout());
  }
  CalibrationMatrix CalibrationCovariance() const {
    return facet::CalibrationCovariance(reduced_, linear_.layout());
  }
  std::vector<Matrix3d> PlaneInformation() const { return facet::PlaneInformation(linear_); }

  /// Median of the norms of the whitened left errors in the newest frame, at the present estimate;
  /// 0 if it sees nothing that constrains.
  double NewestFrameError(const SlidingWindow& window);

 private:
  enum class StepResult { kAccepted, kNothingToGain, kFailed };

  FactorNoise NoiseNow(const SlidingWindow& window, const FactorNoise& noise);
  int Approach(SlidingWindow& window, const FactorNoise& noise, SolveSummary& summary);
  StepResult LinearizeAndStep(SlidingWindow& window,
                              const FactorNoise& noise,
                              CalibrationStep calibration_step,
                              SolveSummary& summary);
  StepResult Step(SlidingWindow& window, const FactorNoise& noise, SolveSummary& summary);

  SolverOptions options_;
  FrameGeometry geometry_;
  LinearizedWindow linear_;
  ReducedSystem reduced_;
  double lambda_ = 0;           // the next damping
  double factored_lambda_ = 0;  // of the last factorisation
  WindowValues before_step_;
  std::vector<double> newest_errors_;  // buffer of NewestFrameError
};

}  // namespace facet
