// SPDX-License-Identifier: BSD-2-Clause
// Planes come into the window, landmarks join and leave them.
#pragma once

#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/planes/plane_evidence.h"
#include "facet/estimator/window/frame_geometry.h"
#include "facet/estimator/window/sliding_window.h"
#include "facet/map/plane_assignments.h"

namespace facet {

/// Which landmarks a plane takes on: beyond these limits their rows would be linearised where they
/// mean nothing.
struct AttachmentLimits {
  /// 1-sigma across the plane. Five times what landmarks of a plane scatter.
  double max_sigma_m = 0.1;
  /// From the plane, or three of the landmark's sigmas, or what the assignment allows, whichever is
  /// most. The mesh has said that the landmark lies on the plane; this is about gross errors.
  double max_distance_m = 0.03;
};

/// Adds the created planes, the links, the relations and the measurements, and takes back what
/// left. Landmarks that are not in the window, and unknown planes and frames, are passed over. So
/// are landmarks beyond `limits`. How much the row of a landmark counts, `evidence` says.
/// `geometry` must be up to date.
void ApplyAssignments(const PlaneAssignments& assignments,
                      const AttachmentLimits& limits,
                      const FactorNoise& noise,
                      const FrameGeometry& geometry,
                      const PlaneEvidence& evidence,
                      SlidingWindow& window);

/// Pipeline SP: sets and, if `convert_back`, clears WindowLandmark::is_projection.
void ApplyProjections(const PlaneAssignments& assignments,
                      bool convert_back,
                      SlidingWindow& window);

/// Cuts the links whose landmark, as vision alone would place it, is more than `max_sigma` from its
/// plane. Returns how many. `geometry` must be up to date.
int DetachOutliers(const FrameGeometry& geometry,
                   const FactorNoise& noise,
                   double max_sigma,
                   SlidingWindow& window);

/// Removes planes that the prior knows nothing of and that fewer than `min_landmarks` lie on, or no
/// landmark at all if a frame of the window has measured them: too little would determine them.
void RemoveSparsePlanes(int min_landmarks, SlidingWindow& window);

/// Sets the sigma of each plane's rows. What n landmarks have in common (prints, frames and panels
/// stand in front of a wall) does not become less with n: the mean of rows with the variance
/// s^2 + n c^2 has the variance s^2 / n + c^2. Rows that the prior has taken up are not counted: c
/// is for the landmarks of a window; those of the next are on other things. Surfaces that are not
/// flat (WindowPlane::unevenness_m) have both more.
void WeighPlanes(const FactorNoise& noise, SlidingWindow& window);

}  // namespace facet
