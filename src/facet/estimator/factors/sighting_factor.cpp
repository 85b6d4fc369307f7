// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/sighting_factor.h"

#include "facet/estimator/factors/robust_loss.h"

namespace facet {

static_assert(Factor<SightingFactor>);

// Equation (9.2).
Vector3d SightingFactor::Error() const {
  const SE3& T_WB = frame_.x.T_WB;
  return {sighted_.SignedDistance(T_WB * sighting_.centre_B) / sighting_.sigma_m,
          sighted_.n.dot(T_WB.q * sighting_.along_B[0]) / sighting_.sigma_rad[0],
          sighted_.n.dot(T_WB.q * sighting_.along_B[1]) / sighting_.sigma_rad[1]};
}

// Equation (9.3): X = p + R c, dX = dp - R Hat(c) dtheta.
SightingRows SightingFactor::Linearize() const {
  SightingRows rows;
  rows.r = Error();
  const SE3& T_WB = frame_.lin.T_WB;
  const Matrix3d R_WB = T_WB.R();
  const Eigen::RowVector3d n_B = sighted_.n_lin.transpose() * R_WB;
  const Matrix<3, 2> tangents = TangentBasis(sighted_.n_lin);
  const Vector3d lever = T_WB * sighting_.centre_B - sighted_.anchor_W;
  rows.J_pose.row(0) << -n_B * Hat(sighting_.centre_B), sighted_.n_lin.transpose();
  rows.J_plane.row(0) << lever.transpose() * tangents, -1;
  rows.J_pose.row(0) /= sighting_.sigma_m;
  rows.J_plane.row(0) /= sighting_.sigma_m;
  for (int k = 0; k < 2; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Vector3d& along_B = sighting_.along_B[i];
    rows.J_pose.row(1 + k).head<3>() = -n_B * Hat(along_B) / sighting_.sigma_rad[i];
    rows.J_plane.row(1 + k).head<2>() =
        (R_WB * along_B).transpose() * tangents / sighting_.sigma_rad[i];
  }
  const RobustLoss loss = HuberLoss(rows.r.norm(), huber_sigma_);
  rows.cost = loss.cost;
  rows.r *= loss.root_weight;
  rows.J_pose *= loss.root_weight;
  rows.J_plane *= loss.root_weight;
  return rows;
}

double SightingFactor::Cost() const {
  return HuberLoss(Error().norm(), huber_sigma_).cost;
}

double SightingFactor::AddTo(NormalEquations& equations) const {
  const SightingRows rows = Linearize();
  equations.AddSquare(plane_, rows.J_plane, rows.r);
  equations.AddSquare(pose_, rows.J_pose, rows.r);
  equations.AddProduct(pose_, rows.J_pose, plane_, rows.J_plane);
  return rows.cost;
}

}  // namespace facet
