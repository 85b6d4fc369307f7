// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/window_calibration.h"

#include <Eigen/Cholesky>

#include "facet/calibration/triangulation_jacobian.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

// Inverse of a covariance whose variances span many orders of magnitude.
CalibrationMatrix InformationOf(const CalibrationMatrix& covariance) {
  const CalibrationVector scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const CalibrationMatrix correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const CalibrationMatrix inverse = correlation.llt().solve(CalibrationMatrix::Identity());
  return scale.asDiagonal() * (0.5 * (inverse + inverse.transpose())) * scale.asDiagonal();
}

}  // namespace

Matrix<6, kNumMount> MountJacobian(const Matrix3d& R_WB, const BodyRates& rates) {
  Matrix<6, kNumMount> A = Matrix<6, kNumMount>::Zero();
  A.topLeftCorner<3, 3>().setIdentity();
  A.block<3, 3>(3, 3) = R_WB;
  A.col(6) << rates.w_B, R_WB * rates.v_B;
  return A;
}

std::optional<Matrix<3, kNumCalibration>> PointJacobian(const StereoRig& rig,
                                                        const Vector3d& X_B,
                                                        const BodyRates& rates) {
  const auto of_lens = TriangulationJacobian(rig, rig.T_BC[0].Inverse() * X_B);
  if (!of_lens) return std::nullopt;
  Matrix<3, kNumCalibration> J;
  J.leftCols<kNumRigParameters>() = rig.T_BC[0].R() * *of_lens;
  J.middleCols<3>(kMountRotation) = -Hat(X_B);
  J.middleCols<3>(kMountTranslation).setIdentity();
  J.col(kTimeOffset) = rates.w_B.cross(X_B) + rates.v_B;
  J.rightCols<3>().setZero();
  return J;
}

WindowCalibration::WindowCalibration(const StereoRig& nominal, const CalibrationMatrix& covariance)
    : start_information(InformationOf(covariance)), nominal_(nominal), T_BC_(nominal.T_BC) {}

void WindowCalibration::Restart(const CalibrationMatrix& covariance) {
  start_mean_ = delta_;
  start_information = InformationOf(covariance);
}

void WindowCalibration::SetDelta(const CalibrationVector& delta) {
  delta_ = delta;
  const SE3 mount(ExpSO3(delta.segment<3>(kMountRotation)), delta.segment<3>(kMountTranslation));
  const SE3 T_C1C0 = nominal_.T_C1C0().Retract(delta.segment<3>(kStereoRotation),
                                               delta.segment<3>(kStereoTranslation));
  T_BC_[0] = mount * nominal_.T_BC[0];
  T_BC_[1] = T_BC_[0] * T_C1C0.Inverse();
}

StereoRig WindowCalibration::Refined() const {
  std::optional<StereoRig> rig = ChangeParameters(nominal_, delta_.head<kNumRigParameters>());
  if (!rig) rig = nominal_;
  rig->T_BC = T_BC_;
  rig->time_offset = nominal_.time_offset + FromSeconds(delta_(kTimeOffset));
  rig->gyro_scale = nominal_.gyro_scale + delta_.tail<3>();
  return *rig;
}

Vector3d WindowCalibration::gyro_scale() const {
  return nominal_.gyro_scale + delta_.tail<3>();
}

SE3 WindowCalibration::AtImage(const SE3& T_WB, const BodyRates& rates) const {
  const double dt = delta_(kTimeOffset);
  return {(T_WB.q * ExpSO3(dt * rates.w_B)).normalized(), T_WB.p + T_WB.q * (dt * rates.v_B)};
}

}  // namespace facet
