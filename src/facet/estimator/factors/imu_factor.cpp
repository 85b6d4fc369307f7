// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/imu_factor.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "facet/geometry/so3.h"

namespace facet {

static_assert(Factor<ImuFactor>);

namespace {

// What the measured motion changes by since its bias and scale have changed.
Vector<9> Correction(const ImuPreintegration& measured,
                     const ImuBias& bias,
                     const Vector3d& gyro_scale) {
  Vector<6> db;
  db << bias.b_g - measured.bias().b_g, bias.b_a - measured.bias().b_a;
  return measured.BiasJacobian() * db +
         measured.ScaleJacobian() * (gyro_scale - measured.gyro_scale());
}

// `correction`: of the measured angles.
Vector3d RotationError(const ImuPreintegration& measured,
                       const NavState& i,
                       const NavState& j,
                       const Vector3d& correction) {
  const Quaterniond dR = measured.dR() * ExpSO3(correction);
  return LogSO3(dR.conjugate() * (i.T_WB.q.conjugate() * j.T_WB.q));
}

Vector<15> CorrectedError(const ImuPreintegration& measured,
                          const NavState& i,
                          const NavState& j,
                          const Vector<9>& correction) {
  const double T = measured.dt();
  const Vector3d g = measured.g_W();
  const Quaterniond q_i_inv = i.T_WB.q.conjugate();

  Vector<15> r;
  r.segment<3>(0) = RotationError(measured, i, j, correction.head<3>());
  r.segment<3>(3) = q_i_inv * (j.T_WB.p - i.T_WB.p - i.v_WB * T - 0.5 * g * T * T) - measured.dp() -
                    correction.segment<3>(3);
  r.segment<3>(6) = q_i_inv * (j.v_WB - i.v_WB - g * T) - measured.dv() - correction.tail<3>();
  r.segment<3>(9) = j.bias.b_g - i.bias.b_g;
  r.segment<3>(12) = j.bias.b_a - i.bias.b_a;
  return r;
}

}  // namespace

Vector<15> ImuError(const ImuPreintegration& measured,
                    const NavState& i,
                    const NavState& j,
                    const Vector3d& gyro_scale) {
  return CorrectedError(measured, i, j, Correction(measured, i.bias, gyro_scale));
}

ImuResidual LinearizeImu(const ImuPreintegration& measured,
                         const NavState& i,
                         const NavState& j,
                         const Vector3d& gyro_scale) {
  const double T = measured.dt();
  const Vector3d g = measured.g_W();
  const Matrix<9, 6>& Jb = measured.BiasJacobian();
  const Matrix<9, 3>& Js = measured.ScaleJacobian();
  const Matrix3d R_BiW = i.T_WB.R().transpose();
  const Matrix3d R_WBj = j.T_WB.R();

  const Vector<9> correction = Correction(measured, i.bias, gyro_scale);

  ImuResidual out;
  out.r = CorrectedError(measured, i, j, correction);
  const Vector3d r_theta = out.r.head<3>();
  const Matrix3d Jr_inv = RightJacobianInverseSO3(r_theta);
  // d r_theta / d (the angles that the measured rotation is corrected by).
  const Matrix3d J_correction = -Jr_inv * ExpSO3(r_theta).toRotationMatrix().transpose() *
                                RightJacobianSO3(correction.head<3>());

  Matrix<15, 15>& Ji = out.J_i;
  Matrix<15, 15>& Jj = out.J_j;
  Ji.setZero();
  Jj.setZero();
  Ji.block<3, 3>(0, 0) = -Jr_inv * (R_BiW * R_WBj).transpose();
  Ji.block<3, 3>(0, 9) = J_correction * Jb.block<3, 3>(0, 0);
  Jj.block<3, 3>(0, 0) = Jr_inv;

  Ji.block<3, 3>(3, 0) = Hat(R_BiW * (j.T_WB.p - i.T_WB.p - i.v_WB * T - 0.5 * g * T * T));
  Ji.block<3, 3>(3, 3) = -R_BiW;
  Ji.block<3, 3>(3, 6) = -R_BiW * T;
  Ji.block<3, 6>(3, 9) = -Jb.block<3, 6>(3, 0);
  Jj.block<3, 3>(3, 3) = R_BiW;

  Ji.block<3, 3>(6, 0) = Hat(R_BiW * (j.v_WB - i.v_WB - g * T));
  Ji.block<3, 3>(6, 6) = -R_BiW;
  Ji.block<3, 6>(6, 9) = -Jb.block<3, 6>(6, 0);
  Jj.block<3, 3>(6, 6) = R_BiW;

  Ji.block<6, 6>(9, 9) = -Matrix<6, 6>::Identity();
  Jj.block<6, 6>(9, 9) = Matrix<6, 6>::Identity();

  // The measured angles without their noise, which the error shows: with it, the scale would learn
  // the noise's variance, and walk away at rest. Not at the present scale: the prior keeps what a
  // link says at fixed points.
  const Vector3d by_bias = Jb.topLeftCorner<3, 3>() * Vector3d(i.bias.b_g - measured.bias().b_g);
  const Vector3d noise = RotationError(measured, i, j, by_bias);
  const Matrix3d by_scale = Js.topRows<3>() - Matrix3d(noise.asDiagonal());
  out.J_scale << J_correction * by_scale, -Js.bottomRows<6>(), Matrix<6, 3>::Zero();
  return out;
}

// The rows of the motion have nothing to do with the biases at its end, those of the biases only
// with the same bias at both ends.
ImuSquares Square(const Matrix<15, 15>& sqrt_info, const ImuResidual& linear, const Vector<15>& r) {
  constexpr int kUsed = 24, kBiases_i = 9, kBiases_j = 24;
  const Matrix<9, 9> root = sqrt_info.topLeftCorner<9, 9>();
  ImuSquares out;
  out.J.leftCols<15>() = root.lazyProduct(linear.J_i.topRows<9>());
  out.J.middleCols<9>(15) = root.lazyProduct(linear.J_j.topLeftCorner<9, 9>());
  out.J.rightCols<6>().setZero();
  const Matrix<kUsed, 9> transposed = out.J.leftCols<kUsed>().transpose();
  out.H.setZero();
  out.H.topLeftCorner<kUsed, kUsed>() = transposed.lazyProduct(transposed.transpose());
  out.b << transposed.lazyProduct(r.head<9>()), Vector<6>::Zero();
  const Vector<6> of_biases = sqrt_info.diagonal().tail<6>();
  const Vector<6> information = of_biases.cwiseAbs2(),
                  gradient = of_biases.cwiseProduct(r.tail<6>());
  out.H.diagonal().segment<6>(kBiases_i) += information;
  out.H.diagonal().segment<6>(kBiases_j) += information;
  out.H.block<6, 6>(kBiases_i, kBiases_j).diagonal() -= information;
  out.H.block<6, 6>(kBiases_j, kBiases_i).diagonal() -= information;
  out.b.segment<6>(kBiases_i) -= gradient;
  out.b.segment<6>(kBiases_j) += gradient;
  return out;
}

namespace {

// Of a consumer's sensor, which the model does not have: the accelerometer's scale, misalignment,
// and the gyroscope's scale while it is not known yet.
constexpr double kUnknownScale = 0.003;
// The factors count with more noise than a gyroscope has, which is best for the poses; who asks
// whether it contradicts the images asks for less.
constexpr double kGyroIsBetter = 1.5;

// What is left of an error that the scale of the sensor can explain.
Vector3d Beyond(const Vector3d& error, const Vector3d& measured) {
  const double size = error.norm(), explained = kUnknownScale * measured.norm();
  // Also what is not a number is left.
  return size <= explained ? Vector3d(Vector3d::Zero()) : Vector3d((1 - explained / size) * error);
}

}  // namespace

double ImuErrorSigma(const ImuLink& link,
                     const NavState& i,
                     const NavState& j,
                     const Vector3d& gyro_scale) {
  const ImuPreintegration& imu = link.measured;
  Vector<15> error = ImuError(imu, i, j, gyro_scale);
  error.segment<3>(0) = Beyond(error.segment<3>(0), LogSO3(imu.dR()));
  error.segment<3>(3) = Beyond(error.segment<3>(3), imu.dp());
  error.segment<3>(6) = Beyond(error.segment<3>(6), imu.dv());
  const Vector<15> r = link.sqrt_info * error;
  const double rotation = kGyroIsBetter * std::sqrt(r.segment<3>(0).squaredNorm() / 3);
  const double sigma = std::max(rotation, std::sqrt(r.segment<6>(3).squaredNorm() / 6));
  return std::isfinite(r.sum()) ? sigma : std::numeric_limits<double>::infinity();
}

double ImuPositionError(const ImuLink& link,
                        const NavState& i,
                        const NavState& j,
                        const Vector3d& gyro_scale) {
  const Vector<15> r = link.sqrt_info * ImuError(link.measured, i, j, gyro_scale);
  return r.segment<3>(3).squaredNorm() / 3;
}

Vector<15> ImuFactor::Error() const {
  const ImuLink& link = *frame_j_.imu_link;
  return link.sqrt_info * ImuError(link.measured, frame_i_.x, frame_j_.x, gyro_scale_);
}

double ImuFactor::AddTo(NormalEquations& equations) const {
  const ImuLink& link = *frame_j_.imu_link;
  const Vector<15> r = Error();
  const ImuResidual linear = LinearizeImu(link.measured, frame_i_.lin, frame_j_.lin, gyro_scale_);
  const ImuSquares squares = Square(link.sqrt_info, linear, r);
  const std::initializer_list<Variable> states = {
      Variable::Pose(j_ - 1), Variable::Motion(j_ - 1), Variable::Pose(j_), Variable::Motion(j_)};
  equations.AddSquares(states, squares.H, squares.b);
  if (equations.layout.calibration_column >= 0) {
    const Matrix<9, 3> J_scale =
        link.sqrt_info.topLeftCorner<9, 9>().lazyProduct(linear.J_scale.topRows<9>());
    const Vector<9> of_motion = r.head<9>();
    equations.AddCalibrationColumns(kGyroScale, J_scale, of_motion, states, squares.J);
  }
  return 0.5 * r.squaredNorm();
}

}  // namespace facet
