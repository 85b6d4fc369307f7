// SPDX-License-Identifier: BSD-2-Clause
// The directions that stereo and IMU leave open: translation x y z, turn about the vertical through
// a pivot. Equations (5.3), (5.4) and (7.3) of docs/math.md, at the linearisation points.
#pragma once

#include "facet/estimator/window/state_layout.h"
#include "facet/geometry/so3.h"

namespace facet::testing {

inline Matrix<15, 4> GaugeDirections(const NavState& x, const Vector3d& pivot_W) {
  Matrix<15, 4> N = Matrix<15, 4>::Zero();
  const Vector3d e_z = Vector3d::UnitZ();
  N.block<3, 3>(3, 0) = Matrix3d::Identity();
  N.block<3, 1>(0, 3) = x.T_WB.q.conjugate() * e_z;
  N.block<3, 1>(3, 3) = e_z.cross(x.T_WB.p - pivot_W);
  N.block<3, 1>(6, 3) = e_z.cross(x.v_WB);
  return N;
}

/// Of a plane: two tangent directions of the normal, offset.
inline Matrix<3, 4> GaugeDirections(const WindowPlane& plane, const Vector3d& pivot_W) {
  Matrix<3, 4> N = Matrix<3, 4>::Zero();
  const Vector3d turn = Vector3d::UnitZ().cross(plane.n_lin);
  N.block<1, 3>(2, 0) = plane.n_lin.transpose();
  N.block<2, 1>(0, 3) = TangentBasis(plane.n_lin).transpose() * turn;
  N(2, 3) = turn.dot(pivot_W - plane.anchor_W);
  return N;
}

/// In the columns of the window's layout.
inline MatrixXd WindowDirections(const SlidingWindow& window, const Vector3d& pivot_W) {
  const StateLayout layout = MakeLayout(window);
  MatrixXd N(layout.dim, 4);
  for (std::size_t k = 0; k < window.planes.size(); ++k)
    N.middleRows<3>(layout.plane_column[k]) = GaugeDirections(window.planes[k], pivot_W);
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    const Matrix<15, 4> N_frame = GaugeDirections(window.frames[i].lin, pivot_W);
    N.middleRows<6>(layout.pose_column[i]) = N_frame.topRows<6>();
    if (window.frames[i].has_motion)
      N.middleRows<9>(layout.motion_column[i]) = N_frame.bottomRows<9>();
  }
  return N;
}

}  // namespace facet::testing
