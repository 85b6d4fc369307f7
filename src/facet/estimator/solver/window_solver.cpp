// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/window_solver.h"

#include <algorithm>

#include "facet/base/median.h"
#include "facet/estimator/factors/reprojection_factor.h"
#include "facet/estimator/solver/window_step.h"

namespace facet {

namespace {

constexpr double kMinLambda = 1e-9;
constexpr double kMaxLambda = 1e4;

double Raised(double lambda) {
  return std::max(lambda * 10, 1e-6);
}

// The newest frame is far from where it belongs if its errors are this many times the usual ones.
constexpr double kFar = 3.0;
constexpr int kMaxApproaches = 8;

}  // namespace

double WindowSolver::NewestFrameError(const SlidingWindow& window) {
  geometry_.Update(window);
  newest_errors_.clear();
  for (const WindowLandmark& landmark : window.landmarks()) {
    // With a single observation the point lies where that says; pipeline SP's have another loss.
    if (!IsConstraining(landmark) || landmark.observations.size() < 2 || landmark.is_projection)
      continue;
    const WindowObservation& o = landmark.observations.back();
    if (o.frame != window.newest_frame()) continue;
    if (const auto error = ReprojectionError(geometry_, landmark, o, 0))
      newest_errors_.push_back(error->norm());
  }
  return Median(newest_errors_).value_or(0.0);
}

// As long as the newest frame is far from where it belongs (a poor prediction, the first estimate
// of a start) everything that it sees would look like an outlier.
FactorNoise WindowSolver::NoiseNow(const SlidingWindow& window, const FactorNoise& noise) {
  FactorNoise now = noise;
  now.reprojection_width =
      std::max(noise.reprojection_width, options_.loss_width * NewestFrameError(window));
  return now;
}

SolveSummary WindowSolver::Solve(SlidingWindow& window,
                                 const FactorNoise& noise,
                                 int max_iterations) {
  SolveSummary summary;
  lambda_ = kMinLambda;
  const int num_approaches = max_iterations > 1 ? Approach(window, noise, summary) : 0;
  for (int iteration = std::min(num_approaches, max_iterations - 1); iteration < max_iterations;
       ++iteration) {
    const StepResult result =
        LinearizeAndStep(window, NoiseNow(window, noise), CalibrationStep::kFree, summary);
    if (result == StepResult::kFailed) break;
    if (result == StepResult::kNothingToGain ||
        linear_.cost - summary.final_cost < options_.min_cost_decrease) {
      summary.converged = true;
      break;
    }
  }
  return summary;
}

// What is new in the window is mostly the newest frame. The first step holds the calibration, and
// so do all until that frame is where it belongs: before, everything it sees would pull at the
// lenses. It is also the cheaper step by half. Returns how many steps it took.
int WindowSolver::Approach(SlidingWindow& window, const FactorNoise& noise, SolveSummary& summary) {
  int num_steps = 0;
  while (num_steps < kMaxApproaches) {
    const FactorNoise now = NoiseNow(window, noise);
    const bool is_far = now.reprojection_width > kFar * noise.reprojection_width;
    if (!is_far && (num_steps > 0 || !window.calibration)) break;
    const StepResult result = LinearizeAndStep(window, now, CalibrationStep::kHeld, summary);
    ++num_steps;
    if (result != StepResult::kAccepted) break;
  }
  lambda_ = kMinLambda;
  return num_steps;
}

WindowSolver::StepResult WindowSolver::LinearizeAndStep(SlidingWindow& window,
                                                        const FactorNoise& noise,
                                                        CalibrationStep calibration_step,
                                                        SolveSummary& summary) {
  Linearize(window, geometry_, noise, calibration_step, linear_);
  if (!summary.initial_cost) summary.initial_cost = summary.final_cost = linear_.cost;
  const StepResult result = Step(window, noise, summary);
  if (result == StepResult::kAccepted) ++summary.iterations;
  return result;
}

// Starts at the present linearisation and increases the damping until a step lowers the cost.
WindowSolver::StepResult WindowSolver::Step(SlidingWindow& window,
                                            const FactorNoise& noise,
                                            SolveSummary& summary) {
  while (lambda_ <= kMaxLambda) {
    factored_lambda_ = lambda_;
    if (!reduced_.Solve(lambda_, linear_)) {
      lambda_ = Raised(lambda_);
      continue;
    }
    summary.ok = true;
    before_step_.Save(window);
    ApplyStep(linear_, reduced_.step(), window);
    geometry_.Update(window);
    const double new_cost = WindowCost(window, geometry_, noise);
    if (new_cost <= linear_.cost) {
      summary.final_cost = new_cost;
      lambda_ = std::max(lambda_ * 0.1, kMinLambda);
      return StepResult::kAccepted;
    }
    before_step_.Restore(window);
    // With first-estimate Jacobians the gradient is slightly off: an uphill step this small is the
    // end.
    if (new_cost - linear_.cost < options_.min_cost_decrease) return StepResult::kNothingToGain;
    lambda_ = Raised(lambda_);
  }
  return StepResult::kFailed;
}

Matrix<15, 15> WindowSolver::NewestFrameCovariance() {
  // Damping is no information: it must not be in the factor.
  if (factored_lambda_ > kMinLambda) {
    if (reduced_.Solve(kMinLambda, linear_)) {
      factored_lambda_ = kMinLambda;
    } else {
      reduced_.Solve(factored_lambda_, linear_);  // the failure has spoiled that factor
    }
  }
  return facet::NewestFrameCovariance(reduced_, linear_.layout());
}

}  // namespace facet
