// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/window_calibration.h"

#include "facet/calibration/triangulation_jacobian.h"
#include "facet/estimator/window/calibration_information.h"
#include "facet/geometry/so3.h"

namespace facet {

Matrix<6, kNumMount> MountJacobian(const Matrix3d& R_WB, const BodyRates& rates) {
  Matrix<6, kNumMount> A = Matrix<6, kNumMount>::Zero();
  A.topLeftCorner<3, 3>().setIdentity();
  A.block<3, 3>(3, 3) = R_WB;
  A.col(6) << rates.w_B, R_WB * rates.v_B;
  return A;
}

WindowCalibration::WindowCalibration(const StereoRig& nominal, const CalibrationMatrix& covariance)
    : start_information(InformationOf(covariance)),
      nominal_(nominal),
      modes_(std::make_shared<const std::array<LensModes, 2>>(
          std::array{LensModes(nominal.cameras[0]), LensModes(nominal.cameras[1])})),
      T_BC_(nominal.T_BC) {}

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
  rig->gyro_scale = nominal_.gyro_scale + delta_.segment<3>(kGyroScale);
  for (int c = 0; c < 2; ++c)
    rig->lens_modes[static_cast<std::size_t>(c)] = LensModesAtPresent(c);
  return *rig;
}

Vector3d WindowCalibration::gyro_scale() const {
  return nominal_.gyro_scale + delta_.segment<3>(kGyroScale);
}

// A mode moves pixels as the principal point does, by what it is where the point is seen.
std::optional<Matrix<3, kNumCalibration>> WindowCalibration::PointJacobian(
    const Vector3d& X_B, const BodyRates& rates) const {
  const Vector3d p_C0 = nominal_.T_BC[0].Inverse() * X_B;
  const std::array p_C = {p_C0, nominal_.T_C1C0() * p_C0};
  const auto of_lens = TriangulationJacobian(nominal_, p_C0);
  if (!of_lens) return std::nullopt;
  const Matrix3d R_BC0 = nominal_.T_BC[0].R();
  Matrix<3, kNumCalibration> J;
  J.leftCols<kNumRigParameters>() = R_BC0 * *of_lens;
  J.middleCols<2 * kNumLensModes>(kLensModes).setZero();
  for (int c = 0; c < 2 && !are_modes_settled_; ++c) {
    const std::size_t i = static_cast<std::size_t>(c);
    const auto px = nominal_.cameras[i].Project(p_C[i]);
    if (!px) return std::nullopt;
    const Matrix<3, 2> by_px = R_BC0 * of_lens->middleCols<2>(c * kNumIntrinsics + kPrincipalPoint);
    J.middleCols<kNumLensModes>(kLensModes + c * kNumLensModes) = by_px * (*modes_)[i].At(*px);
  }
  J.middleCols<3>(kMountRotation) = -Hat(X_B);
  J.middleCols<3>(kMountTranslation).setIdentity();
  J.col(kTimeOffset) = rates.w_B.cross(X_B) + rates.v_B;
  J.middleCols<3>(kGyroScale).setZero();
  return J;
}

SE3 WindowCalibration::AtImage(const SE3& T_WB, const BodyRates& rates) const {
  const double dt = delta_(kTimeOffset);
  return {(T_WB.q * ExpSO3(dt * rates.w_B)).normalized(), T_WB.p + T_WB.q * (dt * rates.v_B)};
}

}  // namespace facet
