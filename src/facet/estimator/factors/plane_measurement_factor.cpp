// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/plane_measurement_factor.h"

#include "facet/estimator/factors/robust_loss.h"
#include "facet/geometry/so3.h"

namespace facet {

static_assert(Factor<PlaneMeasurementFactor>);

// Equation (9.2).
Vector3d PlaneMeasurementFactor::Error() const {
  const SE3& T_WB = frame_.x.T_WB;
  Vector3d error(
      measured_plane_.SignedDistance(T_WB * measurement_.centre_B) / measurement_.sigma_m,
      measured_plane_.n.dot(T_WB.q * measurement_.along_B[0]) / measurement_.sigma_rad[0],
      measured_plane_.n.dot(T_WB.q * measurement_.along_B[1]) / measurement_.sigma_rad[1]);
  if (calibration_ != nullptr) {
    error += InverseSigmas().cwiseProduct(measurement_.J_calibration *
                                          (calibration_->delta() - measurement_.measured_at));
  }
  return error;
}

Vector3d PlaneMeasurementFactor::InverseSigmas() const {
  return Vector3d(measurement_.sigma_m, measurement_.sigma_rad[0], measurement_.sigma_rad[1])
      .cwiseInverse();
}

// Equation (9.3): X = p + R c, dX = dp - R Hat(c) dtheta.
PlaneMeasurementRows PlaneMeasurementFactor::Linearize() const {
  PlaneMeasurementRows rows;
  rows.r = Error();
  const SE3& T_WB = frame_.lin.T_WB;
  const Matrix3d R_WB = T_WB.R();
  const Eigen::RowVector3d n_B = measured_plane_.n_lin.transpose() * R_WB;
  const Matrix<3, 2> tangents = TangentBasis(measured_plane_.n_lin);
  const Vector3d lever = T_WB * measurement_.centre_B - measured_plane_.anchor_W;
  rows.J_pose.row(0) << -n_B * Hat(measurement_.centre_B), measured_plane_.n_lin.transpose();
  rows.J_plane.row(0) << lever.transpose() * tangents, -1;
  rows.J_pose.row(0) /= measurement_.sigma_m;
  rows.J_plane.row(0) /= measurement_.sigma_m;
  for (int k = 0; k < 2; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Vector3d& along_B = measurement_.along_B[i];
    rows.J_pose.row(1 + k).head<3>() = -n_B * Hat(along_B) / measurement_.sigma_rad[i];
    rows.J_plane.row(1 + k).head<2>() =
        (R_WB * along_B).transpose() * tangents / measurement_.sigma_rad[i];
  }
  const RobustLoss loss = HuberLoss(rows.r.norm(), huber_sigma_);
  rows.cost = loss.cost;
  rows.r *= loss.root_weight;
  rows.J_pose *= loss.root_weight;
  rows.J_plane *= loss.root_weight;
  if (calibration_ != nullptr) {
    rows.J_calibration =
        loss.root_weight * InverseSigmas().asDiagonal() * measurement_.J_calibration;
  }
  return rows;
}

double PlaneMeasurementFactor::Cost() const {
  return HuberLoss(Error().norm(), huber_sigma_).cost;
}

double PlaneMeasurementFactor::AddTo(NormalEquations& equations) const {
  const PlaneMeasurementRows rows = Linearize();
  equations.AddSquare(plane_, rows.J_plane, rows.r);
  equations.AddSquare(pose_, rows.J_pose, rows.r);
  equations.AddProduct(pose_, rows.J_pose, plane_, rows.J_plane);
  if (equations.layout.calibration_column >= 0) {
    const Variable calibration = Variable::Calibration();
    equations.AddSquare(calibration, rows.J_calibration, rows.r);
    equations.AddProduct(calibration, rows.J_calibration, plane_, rows.J_plane);
    equations.AddProduct(pose_, rows.J_pose, calibration, rows.J_calibration);
  }
  return rows.cost;
}

}  // namespace facet
