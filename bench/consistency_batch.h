// SPDX-License-Identifier: BSD-2-Clause
// The reference that a fixed-lag smoother is measured against: all keyframes with full states, all
// IMU links and all landmarks in one window, nothing marginalised.
#pragma once

#include <vector>

#include "facet/estimator/vio_estimator.h"

namespace facet {

struct BatchSolution {
  std::vector<NavState> states;  ///< oldest first
  FrameId last_frame;
  Matrix<15, 15> last_covariance = Matrix<15, 15>::Zero();
};

/// Not thread-safe.
class BatchProblem {
 public:
  BatchProblem(const StereoRig& rig, const ImuNoise& noise, const EstimatorOptions& options);

  /// Takes over the estimator's window as it is at its first output.
  void Begin(const SlidingWindow& window);

  /// Each later frame; `estimate` is where a keyframe's state starts from.
  void AddFrame(const FrameObservations& observations,
                const ImuInterval& imu,
                const NavState& estimate);

  BatchSolution Solve(int max_iterations);

 private:
  void AddObservations(const FrameObservations& observations);
  void RelinearizeImu();

  StereoRig rig_;
  EstimatorOptions options_;
  ImuParameters imu_noise_;
  BiasWalk bias_walk_;
  SlidingWindow window_;
  ImuPreintegration imu_;  // since the newest keyframe
};

}  // namespace facet
