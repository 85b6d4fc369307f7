// SPDX-License-Identifier: BSD-2-Clause
// How good the planes of a run are: which true surfaces it found, which of its planes exist, and
// how far they are off where their landmarks lie.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "facet/eval/trajectory_alignment.h"
#include "facet/io/planes_file.h"

namespace facet {

struct PlaneErrorOptions {
  double max_angle_deg = 10;      ///< between the normals of two planes that match
  double max_offset_m = 0.10;     ///< distance of the support's centre from the true plane
  double min_seen_area_m2 = 0.5;  ///< smaller true surfaces do not count for the recall
  /// A plane whose support is this many times as large as a true surface is not that surface.
  double max_area_ratio = 4;
};

struct PlaneError {
  int num_true = 0;  ///< large enough to count
  int num_estimated = 0;
  int num_matched = 0;     ///< one to one
  int num_duplicates = 0;  ///< more planes on a surface that another plane already has
  /// Seen area of the true planes found, over that of all; absent when there is none to find.
  std::optional<double> recall;
  /// Share of the estimated planes that lie on a true surface, however small; absent without any.
  std::optional<double> precision;
  std::optional<double> normal_error_deg_median, offset_error_m_median;
};

/// True planes take, from the largest seen area down, the best estimate (least sum of angle and
/// offset over their limits) within the limits that is still free.
PlaneError EvaluatePlanes(std::span<const EstimatedPlane> estimated_W,
                          std::span<const TruePlane> truth_G,
                          const TrajectoryAlignment& alignment,
                          const PlaneErrorOptions& options = {});

}  // namespace facet
