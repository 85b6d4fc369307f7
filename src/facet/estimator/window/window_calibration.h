// SPDX-License-Identifier: BSD-2-Clause
// The calibration as a variable of the window: how far the lenses, the stereo pair, the mount of
// the cameras on the IMU and the clock of the cameras are from what the calibration files say
// (docs/math.md, section 10).
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "facet/calibration/calibration_vector.h"
#include "facet/calibration/lens_modes.h"
#include "facet/estimator/window/variable.h"

namespace facet {

static_assert(SizeOf(Variable::Kind::kCalibration) == kNumCalibration);

/// How a frame moves while its image is taken, in B: what a time offset does to its pose.
struct BodyRates {
  Vector3d w_B = Vector3d::Zero();  ///< [rad/s]
  Vector3d v_B = Vector3d::Zero();  ///< [m/s]
};

/// d (theta p) / d (mount rotation, mount translation, time offset) of a frame.
Matrix<6, kNumMount> MountJacobian(const Matrix3d& R_WB, const BodyRates& rates);

/// All measurements are linear in the deviation, at the nominal calibration: it is the point of
/// first estimates, as for the frames that the prior touches.
class WindowCalibration {
 public:
  WindowCalibration(const StereoRig& nominal, const CalibrationMatrix& covariance);

  /// From here on the present deviation is what is known before any measurement, this well.
  void Restart(const CalibrationMatrix& covariance);

  const StereoRig& nominal() const { return nominal_; }
  /// Of both cameras.
  const std::shared_ptr<const std::array<LensModes, 2>>& modes() const { return modes_; }
  const CalibrationVector& delta() const { return delta_; }
  void ApplyStep(const CalibrationVector& step) { SetDelta(delta_ + step); }
  void SetDelta(const CalibrationVector& delta);

  /// The calibration at present; the nominal one where a parameter has left what a camera can be.
  StereoRig Refined() const;

  /// Whether what the lenses do beside their models is known so well that measurements of points
  /// need no columns for it: they say nothing of it then.
  bool are_modes_settled() const { return are_modes_settled_; }
  void SettleModes(bool are_settled) { are_modes_settled_ = are_settled; }

  /// What a lens does beside its model at present.
  LensModeVector LensModesAtPresent(int camera) const {
    return nominal_.lens_modes[static_cast<std::size_t>(camera)] + LensModesOf(delta_, camera);
  }

  /// Camera to body at present.
  const SE3& T_BC(int camera) const { return T_BC_[static_cast<std::size_t>(camera)]; }

  /// By what share the gyroscope reads too much at present.
  Vector3d gyro_scale() const;

  /// d X_B / d calibration of a point of the body that a keyframe has triangulated; rates as of its
  /// frame. Settled modes have zero. Empty where TriangulationJacobian is.
  std::optional<Matrix<3, kNumCalibration>> PointJacobian(const Vector3d& X_B,
                                                          const BodyRates& rates) const;

  /// Where the body is when the image is taken, if it is at T_WB at the nominal stamp.
  SE3 AtImage(const SE3& T_WB, const BodyRates& rates) const;

  /// Information on the deviation before any measurement, from start_mean(); until the first
  /// marginalisation takes it up.
  std::optional<CalibrationMatrix> start_information;
  const CalibrationVector& start_mean() const { return start_mean_; }

 private:
  StereoRig nominal_;
  std::shared_ptr<const std::array<LensModes, 2>> modes_;
  CalibrationVector delta_ = CalibrationVector::Zero();
  bool are_modes_settled_ = false;
  CalibrationVector start_mean_ = CalibrationVector::Zero();
  std::array<SE3, 2> T_BC_;
};

}  // namespace facet
