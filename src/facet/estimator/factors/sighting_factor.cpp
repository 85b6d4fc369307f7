// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/sighting_factor.h"

#include "facet/estimator/factors/robust_loss.h"

namespace facet {

Vector3d SightingError(const PlaneSighting& sighting,
                       const WindowPlane& plane,
                       const WindowFrame& frame) {
  const SE3& T_WB = frame.x.T_WB;
  return {plane.SignedDistance(T_WB * sighting.centre_B) / sighting.sigma_m,
          plane.n.dot(T_WB.q * sighting.along_B[0]) / sighting.sigma_rad[0],
          plane.n.dot(T_WB.q * sighting.along_B[1]) / sighting.sigma_rad[1]};
}

SightingRows LinearizeSighting(const PlaneSighting& sighting,
                               const WindowPlane& plane,
                               const WindowFrame& frame,
                               double huber_sigma) {
  SightingRows rows;
  rows.r = SightingError(sighting, plane, frame);
  const SE3& T_WB = frame.lin.T_WB;
  const Matrix3d R_WB = T_WB.R();
  const Eigen::RowVector3d n_B = plane.n_lin.transpose() * R_WB;
  const Matrix<3, 2> tangents = TangentBasis(plane.n_lin);
  // Equations (9.2) and (9.3): X = p + R c, dX = dp - R Hat(c) dtheta.
  const Vector3d lever = T_WB * sighting.centre_B - plane.anchor_W;
  rows.J_pose.row(0) << -n_B * Hat(sighting.centre_B), plane.n_lin.transpose();
  rows.J_plane.row(0) << lever.transpose() * tangents, -1;
  rows.J_pose.row(0) /= sighting.sigma_m;
  rows.J_plane.row(0) /= sighting.sigma_m;
  for (int k = 0; k < 2; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Vector3d& along_B = sighting.along_B[i];
    rows.J_pose.row(1 + k).head<3>() = -n_B * Hat(along_B) / sighting.sigma_rad[i];
    rows.J_plane.row(1 + k).head<2>() =
        (R_WB * along_B).transpose() * tangents / sighting.sigma_rad[i];
  }
  const RobustLoss loss = HuberLoss(rows.r.norm(), huber_sigma);
  rows.cost = loss.cost;
  rows.r *= loss.root_weight;
  rows.J_pose *= loss.root_weight;
  rows.J_plane *= loss.root_weight;
  return rows;
}

}  // namespace facet
