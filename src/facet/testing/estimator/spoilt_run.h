// SPDX-License-Identifier: BSD-2-Clause
// Runs the estimator on a simulated recording that a test may spoil.
#pragma once

#include <functional>
#include <vector>

#include "facet/estimator/vio_estimator.h"
#include "facet/sim/feature_simulator.h"

namespace facet::testing {

/// Eight seconds at 20 Hz. Camera and IMU clocks differ by more than a frame.
const SimulatedRun& SpoiltRun();

/// What the estimator gets with one frame.
struct EstimatorInput {
  FrameObservations observations;
  ImuInterval imu;
};

/// The i-th one of a run.
EstimatorInput InputOf(const SimulatedRun& run, const ImuBuffer& imu, std::size_t i);
ImuBuffer ImuOf(const SimulatedRun& run);

using Spoil = std::function<void(std::size_t i, EstimatorInput& input)>;

struct Outcome {
  std::vector<EstimatorResult> results;
  int num_resets = 0;
};

/// All of SpoiltRun.
Outcome Estimate(const Spoil& spoil, const EstimatorOptions& options = {});

/// Distance moved between two frames by the estimate against the truth.
double MotionError(const Outcome& outcome, std::size_t from, std::size_t to);

bool IsFinite(const EstimatorResult& result);

/// Ran to the end, is finite wherever it claims to have a state, and is well again over the last
/// second.
void ExpectRecovers(const Outcome& outcome, double max_error);

/// Frames 4 s to 5 s, which many tests spoil.
inline constexpr std::size_t kBadBegin = 80, kBadEnd = 100;
inline bool InBadSecond(std::size_t i) {
  return i >= kBadBegin && i < kBadEnd;
}

}  // namespace facet::testing
