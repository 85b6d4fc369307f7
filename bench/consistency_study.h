// SPDX-License-Identifier: BSD-2-Clause
// Sums up many simulated runs: does the estimator's covariance describe its errors, how fast do
// tilt and biases converge, and how much does the fixed lag cost against one batch solution?
#pragma once

#include <array>
#include <string>
#include <vector>

#include "consistency_run.h"

namespace facet {

/// Parts of the state whose normalised error is reported.
enum class StatePart {
  kPose,
  kPosition,
  kOrientation,
  kTilt,
  kVelocity,
  kGyroBias,
  kAccelBias,
  kAll,
  kCount
};
inline constexpr std::size_t kNumStateParts = static_cast<std::size_t>(StatePart::kCount);
inline constexpr std::array<const char*, kNumStateParts> kStatePartNames = {
    "pose", "position", "orientation", "tilt", "velocity", "gyro bias", "accel bias", "all 15"};

/// Squared error normalised by the covariance, over the degrees of freedom: 1 expected.
using NeesRatios = std::array<double, kNumStateParts>;
NeesRatios ComputeNeesRatios(const FrameError& frame);

struct MeanRatios {
  std::array<double, kNumStateParts> sum{};
  int count = 0;
  void Add(const NeesRatios& ratios);
  double operator[](StatePart part) const;
};

/// NEES by time since the first output, and by kind of frame.
inline constexpr std::array<double, 2> kTimeBounds_s = {2.0, 5.0};
enum class FrameKind { kKeyframe, kPassing, kCount };
struct NeesTable {
  std::array<std::array<MeanRatios, 2>, kTimeBounds_s.size() + 1> by_time;  ///< [time][kind]
  MeanRatios all;
  std::vector<double> pose_by_run;  ///< mean of each run; runs are independent
};

/// Root mean square over the seeds, and what the covariance promises, at one time.
struct ConvergenceRow {
  double elapsed_s = 0;
  int count = 0;
  double tilt_square = 0, tilt_variance = 0;  ///< rad^2, sums over seeds
  double accel_square = 0, accel_variance = 0;
  double gyro_square = 0, gyro_variance = 0;
};

struct AteSums {
  int count = 0;
  double causal = 0, final = 0;  ///< of all runs [m]
  int batch_count = 0;
  double batch = 0, causal_where_batch = 0, final_where_batch = 0;
};

struct ConsistencyFigures {
  std::string name;
  int num_runs = 0;
  int num_resets = 0;
  NeesTable nees;
  std::vector<ConvergenceRow> convergence;
  AteSums ate;
  MeanRatios batch_nees;  ///< of the newest keyframe of each batch solution

  double pose_nees() const { return nees.all[StatePart::kPose]; }
  /// Fixed lag (causal) over batch.
  double ate_ratio() const { return ate.causal_where_batch / ate.batch; }
};

/// Runs all seeds of one scenario; progress goes to stderr.
ConsistencyFigures StudyConsistency(const Scenario& scenario, const ConsistencyOptions& options);

/// Text for a terminal.
void PrintFigures(const ConsistencyFigures& figures);

}  // namespace facet
