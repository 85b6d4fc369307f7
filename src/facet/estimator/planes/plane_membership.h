// SPDX-License-Identifier: BSD-2-Clause
// Planes come into the window, landmarks join and leave them.
#pragma once

#include "facet/estimator/factors/vision_factor.h"
#include "facet/map/plane_assignments.h"

namespace facet {

/// When a landmark may join a plane: a row on a point that is far off, or whose distance from the
/// plane is hardly known, is linearised where it means nothing.
struct JoinLimits {
  double max_sigma_m = 0;  ///< 1-sigma of the landmark across the plane, from vision, poses given
  double max_distance_m = 0;  ///< a landmark nearer than this, or than 3 sigma, may join
};

/// Adds the created planes, the links, the relations and the sightings, and takes back what left.
/// Landmarks that are not in the window or beyond the limits, and unknown planes and frames, are
/// passed over. `geometry` must
/// be up to date.
void ApplyAssignments(const PlaneAssignments& assignments,
                      const JoinLimits& limits,
                      const RobustOptions& robust,
                      const FrameGeometry& geometry,
                      SlidingWindow& window);

/// Pipeline SP: sets and, if `convert_back`, clears WindowLandmark::is_projection.
void ApplyProjections(const PlaneAssignments& assignments,
                      bool convert_back,
                      SlidingWindow& window);

/// Cuts the links whose landmark, as vision alone would place it, is more than `max_sigma` from its
/// plane. Returns how many.
/// `geometry` must be up to date.
int DetachOutliers(const FrameGeometry& geometry,
                   const RobustOptions& robust,
                   double max_sigma,
                   SlidingWindow& window);

/// Removes planes that the prior knows nothing of and that fewer than `min_landmarks` lie on, or no
/// landmark at all if a frame of the window has sighted them: too little would determine them.
void RemoveUnsupportedPlanes(int min_landmarks, SlidingWindow& window);

/// Limits for a plane to count as known: 1-sigma of its offset, and of its normal either as an
/// angle or, for small planes, as what the angle amounts to where the landmarks are.
struct SettledLimits {
  double sigma_normal_rad = 0;
  double sigma_rim_m = 0;  ///< sigma of the normal times the rms distance of landmarks and anchor
  double sigma_offset_m = 0;
};

/// Marks the planes that their landmarks and sightings determine well enough; `information` as from
/// WindowSystem::PlaneInformation. What is settled stays settled.
void MarkSettledPlanes(const std::vector<Matrix3d>& information,
                       const SettledLimits& limits,
                       SlidingWindow& window);

/// Cuts the links of leaving landmarks to planes that are not settled: their rows would freeze the
/// plane where it happens to be.
void CutUnsettledLinks(const std::vector<char>& leaving_landmarks, SlidingWindow& window);

/// Cuts what leaving frames have sighted of planes that are not settled, for the same reason, and
/// what a frame that stays has sighted from the same place: the errors are the same, and at rest
/// they would be counted as new with every keyframe.
void CutSightings(const std::vector<char>& leaving_frames, SlidingWindow& window);

/// Removes the relations of leaving planes to planes that are neither settled nor frozen, for the
/// same reason.
void CutUnsettledRelations(const std::vector<char>& leaving_planes, SlidingWindow& window);

/// How many landmarks lie on each plane.
std::vector<int> CountMembers(const SlidingWindow& window);

/// Sets the sigma of each plane's rows. What n landmarks have in common (prints, frames and panels
/// stand in front of a wall) does not become less with n: the mean of rows with the variance
/// s^2 + n c^2 has the variance s^2 / n + c^2. Rows that the prior has taken up are not counted: c
/// is for the landmarks of a window; those of the next are on other things.
void WeighPlanes(const RobustOptions& robust, SlidingWindow& window);

}  // namespace facet
