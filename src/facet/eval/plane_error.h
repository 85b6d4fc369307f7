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
  double max_angle_deg = 10;   ///< between the normals of two planes that match
  double max_offset_m = 0.10;  ///< distance of the support's centre from the true plane
  /// The same as a share of the distance between the support's centre and the nearest place of the
  /// run, for scenes of any size; above 0 it takes the place of max_offset_m.
  double max_offset_share = 0;
  /// A plane whose support is this many times as large as a true surface is not that surface.
  double max_area_ratio = 4;
  /// Less than this is a boundary seen by chance. Such a surface cannot be found, and must not take
  /// an estimate: the back of a thin board fits as well as its front.
  double min_visible_area_m2 = 0.01;
  double min_area_m2 = 1;       ///< true surfaces count for the recall if they are larger ...
  double min_seen_area_m2 = 1;  ///< ... and at least so much of them was seen
  /// What lies flat on a larger true plane (posters, windows, carpets) is one surface with it:
  /// facing the same way within this angle, ...
  double max_flat_angle_deg = 0.1;
  double max_flat_offset_m = 0.02;  ///< ... its d differs by at most this, ...
  /// ... and the larger one has this many times its area: true planes have no outline, and two
  /// tables of one height are two.
  double min_flat_area_ratio = 4;
};

/// Tighter limits for a second judgement: a plane between two surfaces may pass the wider ones.
inline constexpr PlaneErrorOptions kClosePlanes{.max_angle_deg = 3, .max_offset_m = 0.05};
/// As tight, near and far.
inline constexpr PlaneErrorOptions kClosePlanesByDistance{.max_angle_deg = 3,
                                                          .max_offset_share = 0.02};

struct PlaneError {
  int num_true = 0;  ///< surfaces that count for the recall
  int num_estimated = 0;
  int num_matched = 0;     ///< one to one, with surfaces of any size
  int num_duplicates = 0;  ///< more planes on a surface that another plane already has
  /// Seen area of the surfaces found, over that of all that count; absent when there is none.
  std::optional<double> recall;
  /// Share of the estimated planes that lie on a true surface, however small; absent without any.
  std::optional<double> precision;
  std::optional<double> normal_error_deg_median, offset_error_m_median;
};

/// An estimate matches a true surface that has a plane within the limits of angle and offset, and
/// is compared with its best one. The score is the sum of angle and offset over their limits. Of
/// all pairs the best score is taken first, one to one; equal scores: the surface seen more, then
/// the larger one, then the order of the lists. `path_G`: where the run truly was;
/// needed with max_offset_share only. Throws InputError for lists that hold the same planes so
/// often that the pairs would fill the memory.
PlaneError EvaluatePlanes(std::span<const EstimatedPlane> estimated_W,
                          std::span<const TruePlane> truth_G,
                          const TrajectoryAlignment& alignment,
                          const PlaneErrorOptions& options = {},
                          std::span<const Vector3d> path_G = {});

}  // namespace facet
