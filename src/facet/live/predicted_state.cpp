// SPDX-License-Identifier: BSD-2-Clause
#include "facet/live/predicted_state.h"

#include "facet/geometry/so3.h"

namespace facet {

namespace {

// World to output world.
Matrix3d AxesOf(WorldAxes world) {
  if (world == WorldAxes::kEnu) return Matrix3d::Identity();
  Matrix3d R;
  R << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  return R;
}

}  // namespace

PredictedState InFrame(const PredictedState& state, const OutputFrame& frame) {
  const Matrix3d R_NW = AxesOf(frame.world);
  const Quaterniond q_NW(R_NW);
  const Matrix3d R_FB = frame.T_BF.q.conjugate().toRotationMatrix();
  const Matrix3d R_NB = R_NW * state.T_WF.R();
  const Vector3d& r_B = frame.T_BF.p;
  const Vector3d& w_B = state.w_F;
  const Vector3d v_of_turn_B = w_B.cross(r_B);

  PredictedState out = state;
  out.T_WF = SE3(q_NW * state.T_WF.q, R_NW * state.T_WF.p) * frame.T_BF;
  out.v_WF = R_NW * state.v_WF + R_NB * v_of_turn_B;
  out.w_F = R_FB * w_B;
  out.a_WF = R_NW * state.a_WF + R_NB * w_B.cross(v_of_turn_B);

  Matrix<15, 15> J = Matrix<15, 15>::Identity();
  J.block<3, 3>(0, 0) = R_FB;
  J.block<3, 3>(3, 0) = -R_NB * Hat(r_B);
  J.block<3, 3>(3, 3) = R_NW;
  J.block<3, 3>(6, 0) = -R_NB * Hat(v_of_turn_B);
  J.block<3, 3>(6, 6) = R_NW;
  J.block<3, 3>(6, 9) = R_NB * Hat(r_B);  // a wrong bias is a wrong angular velocity
  out.covariance = J * state.covariance * J.transpose();
  out.held_back = J.topLeftCorner<9, 9>() * state.held_back;
  return out;
}

}  // namespace facet
