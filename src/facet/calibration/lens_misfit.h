// SPDX-License-Identifier: BSD-2-Clause
// A lens that does what its model cannot say.
#pragma once

#include <cstdint>

#include "facet/calibration/intrinsics_jacobian.h"
#include "facet/calibration/smooth_field.h"

namespace facet {

/// A SmoothField without what other intrinsic parameters or another direction of the camera would
/// explain, so that no calibration with the camera's model fits better than the nominal one.
class LensMisfit {
 public:
  /// `rms_px`: root mean square over the image and both axes.
  static LensMisfit Draw(const CameraModel& camera, double rms_px, std::uint64_t seed);

  /// From the pixel that the camera model gives a ray to where the lens puts it. Pixels without a
  /// ray are not displaced.
  Vector2d At(const Vector2d& px) const;

  /// The pixel that the camera model gives the ray which arrives at this one.
  Vector2d Undo(const Vector2d& displaced_px) const;

 private:
  explicit LensMisfit(const CameraModel& camera) : camera_(camera) {}

  CameraModel camera_;
  SmoothField field_;
  Vector<kNumIntrinsics + 3> explained_ = Vector<kNumIntrinsics + 3>::Zero();
  double scale_ = 1;
};

}  // namespace facet
