// SPDX-License-Identifier: BSD-2-Clause
// Rows of the measurements of planes (docs/math.md, section 9): what one keyframe measured of a
// plane as a whole. They touch that keyframe's pose, the plane and, if it is a
// variable, the calibration, which all keyframes share; no landmark.
#pragma once

#include "facet/estimator/factors/factor.h"

namespace facet {

/// Residual and Jacobians of one measurement, whitened and weighted.
struct PlaneMeasurementRows {
  Vector3d r = Vector3d::Zero();  ///< distance at the centre, slopes
  Matrix<3, 6> J_pose = Matrix<3, 6>::Zero();
  Matrix3d J_plane = Matrix3d::Zero();  ///< two directions, offset
  Matrix<3, kNumCalibration> J_calibration = Matrix<3, kNumCalibration>::Zero();
  double cost = 0;
};

/// The sigmas come with the measurement; norms of the whitened residual beyond `huber_sigma` grow
/// linearly.
class PlaneMeasurementFactor {
 public:
  PlaneMeasurementFactor(const SlidingWindow& window,
                         const WindowMeasurement& measurement,
                         double huber_sigma)
      : measurement_(measurement),
        huber_sigma_(huber_sigma),
        plane_(Variable::Plane(window.IndexOf(measurement.plane))),
        pose_(Variable::Pose(window.IndexOf(measurement.frame))),
        measured_plane_(window.planes[plane_.index]),
        frame_(window.frames[pose_.index]),
        calibration_(window.calibration ? &*window.calibration : nullptr) {}

  /// Whitened, at the estimate.
  Vector3d Error() const;
  PlaneMeasurementRows Linearize() const;

  double Cost() const;
  double AddTo(NormalEquations& equations) const;

  /// A measurement is used up when its frame leaves. If the plane alone leaves, it is lost.
  bool IsUsedUp(const MarginalizationPlan& plan) const { return plan.Drops(pose_); }

  template <class Visitor>
  void ForEachVariable(const Visitor& visit) const {
    visit(plane_);
    visit(pose_);
    if (calibration_ != nullptr) visit(Variable::Calibration());
  }

 private:
  Vector3d InverseSigmas() const;

  const WindowMeasurement& measurement_;
  double huber_sigma_;
  Variable plane_, pose_;
  const WindowPlane& measured_plane_;
  const WindowFrame& frame_;
  const WindowCalibration* calibration_;  ///< null: held
};

}  // namespace facet
