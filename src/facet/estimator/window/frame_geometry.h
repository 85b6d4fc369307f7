// SPDX-License-Identifier: BSD-2-Clause
// Where the cameras of all frames are, and what ray a pixel is, as everything that looks at
// landmarks needs it.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "facet/calibration/lens_modes.h"
#include "facet/calibration/present_lens.h"
#include "facet/camera/stereo_rig.h"
#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// Reuse one object: it keeps its storage. Not thread-safe.
class FrameGeometry {
 public:
  struct Pose {
    Matrix3d R_BW;
    Vector3d p_WB;
    Matrix3d R_WC0;
    Vector3d p_WC0;
    Matrix3d R_CW[2];  ///< of the left and the right camera
    Vector3d p_WC[2];
  };

  explicit FrameGeometry(const StereoRig& rig);

  /// Takes the current estimates of all frames and of the calibration. For the Jacobians it takes
  /// the frozen poses, and the nominal calibration.
  void Update(const SlidingWindow& window);

  /// The same with the nominal calibration.
  void Update(const std::vector<WindowFrame>& frames);

  const Pose& current(int frame) const { return current_[frame]; }
  const Pose& frozen(int frame) const { return frozen_[frame]; }

  /// By the last update: whether the calibration is a variable.
  bool has_calibration() const { return has_calibration_; }

  /// And whether measurements say anything of the lenses' modes (WindowCalibration).
  bool estimates_modes() const { return estimates_modes_; }

  /// How much later images are taken than their nominal stamps say [s].
  double time_offset() const { return has_calibration_ ? delta_(kTimeOffset) : 0.0; }

  /// Where the body is when the image of a frame at T_WB is taken.
  SE3 AtImage(const SE3& T_WB, const BodyRates& rates) const;

  const CameraModel& nominal_camera(int camera) const {
    return nominal_.cameras[static_cast<std::size_t>(camera)];
  }
  /// The lens as it is believed to be at present, with all of its deviation to first order; only
  /// with a calibration.
  const PresentLens& present_lens(int camera) const {
    return present_lenses_[static_cast<std::size_t>(camera)];
  }

  /// d pixel / d modes of the lens at a pixel; only with a calibration.
  Matrix<2, kNumLensModes> ModesAt(int camera, const Vector2d& px) const {
    return (*modes_)[static_cast<std::size_t>(camera)].At(px);
  }

  /// By how much the present lens moves the measured point's pixel against the nominal model, to
  /// first order [px].
  Vector2d LensShift_px(const WindowObservation& observation, int camera) const;

  /// The measured bearing, as the present calibration has it.
  Vector3d MeasuredBearing(const WindowObservation& observation, int camera) const;

  /// Of the body, at present.
  Matrix3d R_CB[2];
  Vector3d p_BC[2];

 private:
  StereoRig nominal_;
  std::shared_ptr<const std::array<LensModes, 2>> modes_;
  std::array<PresentLens, 2> present_lenses_;
  bool has_calibration_ = false;
  bool estimates_modes_ = false;
  CalibrationVector delta_ = CalibrationVector::Zero();
  std::vector<Pose> current_;
  std::vector<Pose> frozen_;
};

}  // namespace facet
