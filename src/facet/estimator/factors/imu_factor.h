// SPDX-License-Identifier: BSD-2-Clause
// The IMU between two full states: preintegrated motion (9 rows) and bias walk (6 rows), with the
// scale of the gyroscope where the calibration is a variable. Equations (2.11) to (2.16) of
// docs/math.md; Forster et al., TRO 2017, with additive world position.
#pragma once

#include "facet/estimator/factors/factor.h"

namespace facet {

/// Rows: theta p v b_g b_a. Columns of J_i and J_j: theta p v b_g b_a of the state; of J_scale: the
/// gyroscope's axes.
struct ImuResidual {
  Vector<15> r;
  Matrix<15, 15> J_i;
  Matrix<15, 15> J_j;
  Matrix<15, 3> J_scale;
};

/// Unwhitened residual only, predicted minus measured (rotation: Log(measured^-1 predicted)).
Vector<15> ImuError(const ImuPreintegration& measured,
                    const NavState& i,
                    const NavState& j,
                    const Vector3d& gyro_scale);

/// Unwhitened residual and Jacobians.
ImuResidual LinearizeImu(const ImuPreintegration& measured,
                         const NavState& i,
                         const NavState& j,
                         const Vector3d& gyro_scale);

/// A link's rows times their noise, and their normal equations in theta p v b_g b_a of both states.
struct ImuSquares {
  Matrix<9, 30> J;  ///< of theta p v; those of the biases are in H and b only
  Matrix<30, 30> H;
  Vector<30> b;  ///< gradient
};

/// `r`: the residual that counts, times its noise; `linear`: where the derivatives are taken;
/// `sqrt_info`: of ImuSqrtInfo, whose biases are apart from the motion and from each other.
ImuSquares Square(const Matrix<15, 15>& sqrt_info, const ImuResidual& linear, const Vector<15>& r);

/// How far the two states are from the measured motion: RMS of its whitened errors, those of the
/// rotation (1.5 times) or those of position and velocity, whichever is larger. What 0.3 % of the
/// measured motion explains is no error. Infinite if not a number.
double ImuErrorSigma(const ImuLink& link,
                     const NavState& i,
                     const NavState& j,
                     const Vector3d& gyro_scale);

/// Mean square of what the second position is off from the measured motion, in units of the noise
/// that was assumed; the two velocities have taken up their part of it. Not finite if not a number.
double ImuPositionError(const ImuLink& link,
                        const NavState& i,
                        const NavState& j,
                        const Vector3d& gyro_scale);

/// IMU and images contradict each other beyond this (ImuErrorSigma of a keyframe). What it finds
/// and where it is wrong: docs/notebook/faults.md, from "A blind set of ten faults" on.
inline constexpr double kContradictionSigma = 4;

/// The link of a frame to the one before it. Its noise is in ImuLink::sqrt_info; no robust loss.
class ImuFactor {
 public:
  /// The frame with index `j` must have a link, and both frames motion.
  ImuFactor(const SlidingWindow& window, int j)
      : frame_i_(window.frames[j - 1]),
        frame_j_(window.frames[j]),
        gyro_scale_(window.GyroScale()),
        has_scale_(window.calibration),
        j_(j) {}

  double Cost() const { return 0.5 * Error().squaredNorm(); }
  double AddTo(NormalEquations& equations) const;

  bool IsUsedUp(const MarginalizationPlan& plan) const {
    return plan.Drops(Variable::Motion(j_ - 1)) || plan.Drops(Variable::Motion(j_));
  }

  template <class Visitor>
  void ForEachVariable(const Visitor& visit) const {
    for (const int frame : {j_ - 1, j_}) {
      visit(Variable::Pose(frame));
      visit(Variable::Motion(frame));
    }
    if (has_scale_) visit(Variable::Calibration());
  }

 private:
  Vector<15> Error() const;

  const WindowFrame& frame_i_;
  const WindowFrame& frame_j_;
  Vector3d gyro_scale_;
  bool has_scale_;
  int j_;
};

}  // namespace facet
