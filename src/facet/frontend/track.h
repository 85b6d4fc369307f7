// SPDX-License-Identifier: BSD-2-Clause
// One followed point of the left image.
#pragma once

#include <memory>
#include <optional>

#include "facet/base/types.h"
#include "facet/camera/camera_model.h"
#include "facet/frontend/patch_tracker.h"

namespace facet {

/// State of a followed point after a frame in which it was seen. Slots are reused: an invalid id
/// marks a free slot.
struct Track {
  LandmarkId id;
  Vector2d px = Vector2d::Zero();  ///< in the newest left image
  PixelBearing ray;                ///< of px
  float sigma_px = 0;              ///< from the residuals of the alignment, per axis
  int level = 0;                   ///< finest level of the alignment
  /// [1/m] from the left camera; empty until a right pixel or the estimator told it.
  std::optional<double> inverse_distance;
  /// Bearing at which the predicted rotation alone puts the point in the newest frame.
  Vector3d rotated_bearing = Vector3d::UnitZ();
  /// How far its bearing moved beyond that since the previous frame.
  std::optional<Vector3d> drift;
  /// Bearing in the last keyframe that saw the point there.
  std::optional<Vector3d> keyframe_bearing;
  /// Patch in the newest image, around px; null in a slot that was never used.
  std::unique_ptr<PatchPyramid> patch;
  /// Patch that px is aligned with, from the frame where the track began or was refreshed.
  std::unique_ptr<PatchPyramid> reference;
  PatchWarp reference_warp;  ///< from the reference to the newest image
  /// The reference was taken anew in the newest image, at a place a little beside the earlier one.
  bool is_renewed = false;

  /// Unit vector from the left camera to the point.
  const Vector3d& Bearing() const { return ray.bearing; }
};

}  // namespace facet
