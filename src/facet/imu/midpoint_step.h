// SPDX-License-Identifier: BSD-2-Clause
// One step of the midpoint rule from an IMU sample to the next, and its linearisation
// (docs/math.md, section 2): what preintegration and the prediction between frames have in common.
#pragma once

#include "facet/imu/imu_types.h"

namespace facet {

/// What the IMU measured in one step, without bias and scale.
struct StepMeasurement {
  double dt = 0;    ///< [s]
  Vector3d w;       ///< mean angular rate [rad/s]
  Vector3d a0, a1;  ///< specific force at its start and its end [m/s^2], each in the body then
};

/// Measured between two samples with this bias, and this scale of the gyroscope.
StepMeasurement MeasureStep(const ImuSample& a,
                            const ImuSample& b,
                            const ImuBias& bias,
                            const Vector3d& gyro_scale);

/// Where the step leads to from a body that is turned by R0 against some frame.
struct MidpointStep {
  MidpointStep(const Quaterniond& q0, const StepMeasurement& measured);

  Quaterniond q_step;     ///< the body's turn
  Quaterniond q_end;      ///< q0 q_step
  Matrix3d R0, R1;        ///< of q0 and q_end
  Vector3d acceleration;  ///< mean specific force in that frame [m/s^2]
};

/// The linearisation A of (theta, p, v) at the end of a step in that at its start, and B in the
/// noise of the mean rate and the mean acceleration, (2.8). Most of them is zero, or half of dt
/// times something else in them.
class StepJacobian {
 public:
  StepJacobian(const StepMeasurement& measured, const MidpointStep& step);

  /// M = A M.
  template <int kColumns>
  void Propagate(Matrix<9, kColumns>& M) const {
    const Matrix<3, kColumns> theta = M.template topRows<3>();
    const Matrix<3, kColumns> turned = v_theta_ * theta;
    M.template topRows<3>().noalias() = theta_theta_ * theta;
    M.template middleRows<3>(3) += half_dt_ * turned + 2 * half_dt_ * M.template bottomRows<3>();
    M.template bottomRows<3>() += turned;
  }

  /// B M.
  template <int kColumns>
  Matrix<9, kColumns> OfMeasurement(const Matrix<6, kColumns>& M) const {
    Matrix<9, kColumns> out;
    out.template topRows<3>().noalias() = theta_w_ * M.template topRows<3>();
    const Matrix<3, kColumns> v =
        v_w_ * M.template topRows<3>() + v_a_ * M.template bottomRows<3>();
    out.template middleRows<3>(3) = half_dt_ * v;
    out.template bottomRows<3>() = v;
    return out;
  }

  Matrix<9, 6> B() const;

 private:
  double half_dt_;
  Matrix3d theta_theta_, v_theta_;  // A
  Matrix3d theta_w_, v_w_, v_a_;    // B
};

}  // namespace facet
