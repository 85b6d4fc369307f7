// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/dead_reckoning.h"

#include "facet/geometry/so3.h"

namespace facet {

ReckonedState Reckon(const ReckonedState& from,
                     const ImuPreintegration& measured,
                     const BiasWalk& walk) {
  const double T = measured.dt();
  const Matrix3d R = from.x.T_WB.R();
  const Matrix<9, 6>& J_bias = measured.BiasJacobian();
  Matrix<15, 15> F = Matrix<15, 15>::Identity();
  F.block<3, 3>(0, 0) = measured.dR().conjugate().toRotationMatrix();
  F.block<3, 3>(3, 0) = -R * Hat(measured.dp());
  F.block<3, 3>(6, 0) = -R * Hat(measured.dv());
  F.block<3, 3>(3, 6) = T * Matrix3d::Identity();
  F.block<3, 6>(0, 9) = J_bias.topRows<3>();
  F.block<3, 6>(3, 9) = R * J_bias.middleRows<3>(3);
  F.block<3, 6>(6, 9) = R * J_bias.bottomRows<3>();

  Matrix<9, 9> to_W = Matrix<9, 9>::Identity();
  to_W.block<3, 3>(3, 3) = to_W.block<3, 3>(6, 6) = R;
  ReckonedState to;
  to.x = measured.Predict(from.x);
  to.covariance = F * from.covariance * F.transpose();
  to.covariance.topLeftCorner<9, 9>() += to_W * measured.Covariance() * to_W.transpose();
  to.covariance.block<3, 3>(9, 9).diagonal().array() += walk.gyro * walk.gyro * T;
  to.covariance.block<3, 3>(12, 12).diagonal().array() += walk.accel * walk.accel * T;
  return to;
}

}  // namespace facet
