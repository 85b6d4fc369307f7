// SPDX-License-Identifier: BSD-2-Clause
// How far a trajectory is from its ground truth: absolute error after alignment (ATE) and relative
// error over stretches of path (RPE, all pairs; Geiger et al., CVPR 2012, with evo's pair
// selection).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "facet/eval/trajectory_alignment.h"
#include "facet/io/trajectory_file.h"

namespace facet {

/// An estimate's pose and the truth at the same stamp.
struct PosePair {
  Timestamp t;
  SE3 T_WB;  ///< estimate
  SE3 T_GB;  ///< truth, interpolated
};

struct Association {
  std::vector<PosePair> pairs;
  int num_outside = 0;  ///< poses before the first or after the last truth
  int num_in_gaps = 0;  ///< poses in a hole of the truth
};

/// Interpolates the truth (linearly and by slerp) at the stamps of the estimate. Never
/// extrapolates, and never interpolates across a hole that is longer than 0.1 s and 3 median
/// intervals of the truth. Both are sorted by stamp.
Association Associate(std::span<const StampedPose> estimate, std::span<const StampedPose> truth);

struct ErrorStatistics {
  double rmse = 0, median = 0, mean = 0, max = 0;
};

/// CHECKs that there is at least one value.
ErrorStatistics Summarize(std::vector<double> errors);

/// The alignment that fits the positions of all pairs best. CHECKs that there is at least one.
TrajectoryAlignment AlignPairs(std::span<const PosePair> pairs, AlignmentKind kind);

/// Distances between the truth and the aligned estimate, pair by pair [m].
std::vector<double> AbsoluteErrors(std::span<const PosePair> pairs,
                                   const TrajectoryAlignment& alignment);

/// Errors of the motion over stretches of one length.
struct RelativeErrors {
  double length_m = 0;
  std::vector<double> translation_m;
  std::vector<double> rotation_rad;
};

/// For each start i the pose j > i whose path from i (along the truth) comes closest to length_m;
/// the pair counts if it is within `tolerance` * length_m. Error: (P_i^-1 P_j)^-1 (G_i^-1 G_j).
RelativeErrors ComputeRelativeErrors(std::span<const PosePair> pairs,
                                     double length_m,
                                     double tolerance = 0.01);

/// 1, 2, 5, 10, 20, 30, 40, 50, 100 ... m as far as the path goes; 0.1, 0.2, 0.5 m on a path below
/// 1 m.
std::vector<double> DefaultRpeLengths(double path_length_m);

struct TrajectoryErrorOptions {
  AlignmentKind alignment = AlignmentKind::kSE3;
  std::vector<double> rpe_lengths_m;  ///< empty: DefaultRpeLengths
};

struct TrajectoryError {
  int num_pairs = 0;
  int num_outside = 0;
  int num_in_gaps = 0;
  double path_length_m = 0;  ///< of the truth, between the pairs
  TrajectoryAlignment alignment;
  ErrorStatistics ate_m;
  std::vector<RelativeErrors> rpe;  ///< lengths with at least one pair
  /// Mean of translation error over length, all pairs of all lengths, in percent.
  std::optional<double> drift_percent;
  /// How much larger than the truth the estimate is; absent when nothing moves.
  std::optional<double> scale_error_percent;
};

/// Why the two cannot be compared; empty if they can.
std::string WhatIsWrong(std::span<const StampedPose> estimate, std::span<const StampedPose> truth);

/// CHECKs that WhatIsWrong is empty.
TrajectoryError EvaluateTrajectory(std::span<const StampedPose> estimate,
                                   std::span<const StampedPose> truth,
                                   const TrajectoryErrorOptions& options = {});

}  // namespace facet
