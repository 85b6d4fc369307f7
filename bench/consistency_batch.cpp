// SPDX-License-Identifier: BSD-2-Clause
#include "consistency_batch.h"

#include <Eigen/LU>

#include "facet/estimator/window/landmark_depth.h"

namespace facet {

namespace {

// Squares of normal equations as large as these lose digits: exact to the last one is out of reach.
constexpr double kMinCostDecrease = 1e-4;
constexpr int kRounds = 2;  // solve, integrate the IMU again about the new biases, solve

std::optional<WindowObservation> Prepare(const FeatureObservation& feature,
                                         const StereoRig& rig,
                                         double sigma_scale) {
  const auto left = rig.cameras[0].BearingOf(feature.px_left);
  if (!left) return std::nullopt;
  WindowObservation out;
  out.sigma_px[0] = sigma_scale * feature.sigma_left_px;
  out.rays[0] = {left->bearing, left->J_px_bearing / out.sigma_px[0]};
  if (!feature.px_right) return out;
  if (const auto right = rig.cameras[1].BearingOf(*feature.px_right)) {
    out.has_right = true;
    out.sigma_px[1] = sigma_scale * feature.sigma_right_px;
    out.rays[1] = {right->bearing, right->J_px_bearing / out.sigma_px[1]};
  }
  return out;
}

}  // namespace

BatchProblem::BatchProblem(const StereoRig& rig,
                           const ImuNoise& noise,
                           const EstimatorOptions& options)
    : rig_(rig),
      options_(options),
      imu_noise_(ParametersInUse(noise, options.imu)),
      bias_walk_(noise, options.imu) {}

void BatchProblem::Begin(const SlidingWindow& window) {
  window_ = window;
  imu_ = ImuPreintegration(window_.frames.back().x.bias, imu_noise_);
}

void BatchProblem::AddFrame(const FrameObservations& observations,
                            const ImuInterval& imu,
                            const NavState& estimate) {
  imu_.Integrate(imu.samples);
  if (!observations.is_keyframe) return;
  WindowFrame frame;
  frame.id = observations.frame;
  frame.is_keyframe = true;
  frame.x = frame.lin = estimate;
  frame.imu_link = ImuLink{std::move(imu_)};
  window_.frames.push_back(std::move(frame));
  imu_ = ImuPreintegration(estimate.bias, imu_noise_);
  AddObservations(observations);
}

void BatchProblem::AddObservations(const FrameObservations& observations) {
  const int newest = static_cast<int>(window_.frames.size()) - 1;
  for (const FeatureObservation& feature : observations.features) {
    auto observation = Prepare(feature, rig_, options_.solver.pixel_sigma_scale);
    if (!observation) continue;
    observation->frame = newest;
    WindowLandmark* landmark = window_.Find(feature.landmark);
    if (landmark == nullptr) landmark = &window_.AddLandmark(feature.landmark, newest);
    landmark->observations.push_back(*observation);
  }
}

void BatchProblem::RelinearizeImu() {
  for (std::size_t j = 1; j < window_.frames.size(); ++j) {
    ImuLink& link = window_.frames[j].imu_link.value();
    link.measured.Reintegrate(window_.frames[j - 1].x.bias, window_.GyroScale());
    link.sqrt_info = ImuSqrtInfo(link.measured, bias_walk_);
  }
}

BatchSolution BatchProblem::Solve(int max_iterations) {
  FrameGeometry geometry(rig_);
  geometry.Update(window_.frames);
  InitializeDepths(geometry, window_);
  SolverOptions solver_options = options_.solver;
  solver_options.min_cost_decrease = kMinCostDecrease;
  WindowSolver solver(rig_, solver_options);
  for (int round = 0; round < kRounds; ++round) {
    RelinearizeImu();
    solver.Solve(window_, FactorNoise(options_), max_iterations);
  }
  BatchSolution solution;
  for (const WindowFrame& frame : window_.frames)
    solution.states.push_back(frame.x);
  solution.last_frame = window_.frames.back().id;
  solution.last_covariance = solver.NewestFrameCovariance();
  return solution;
}

}  // namespace facet
