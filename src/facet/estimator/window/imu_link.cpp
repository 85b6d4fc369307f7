// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/imu_link.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Cholesky>

namespace facet {

BiasWalk::BiasWalk(const ImuNoise& noise, const ImuOptions& options)
    : gyro(noise.gyro_walk * options.gyro_walk_scale),
      accel(noise.accel_walk * options.accel_walk_scale) {}

ImuParameters ParametersInUse(const ImuNoise& noise, const ImuOptions& options) {
  ImuParameters parameters;
  parameters.gyro = std::min(noise.gyro_noise, options.max_gyro_noise) * options.gyro_noise_scale;
  parameters.accel =
      std::min(noise.accel_noise, options.max_accel_noise) * options.accel_noise_scale;
  parameters.gravity = options.gravity_mps2;
  return parameters;
}

std::vector<std::string> InflationWarnings(const ImuNoise& noise, const ImuOptions& options) {
  std::vector<std::string> warnings;
  const auto look =
      [&](double density, double most, const char* key, const char* scale, const char* limit) {
        if (density <= most) return;
        char text[400];
        std::snprintf(text,
                      sizeof(text),
                      "'%s' is %.3g in the calibration, more than any usual IMU's: it is taken for "
                      "inflated, and %.3g "
                      "counts, times %s as always; %s=%.3g takes the density as it is",
                      key,
                      density,
                      most,
                      scale,
                      limit,
                      density);
        warnings.emplace_back(text);
      };
  look(noise.gyro_noise,
       options.max_gyro_noise,
       "gyroscope_noise_density",
       "estimator.imu.gyro_noise_scale",
       "estimator.imu.max_gyro_noise");
  look(noise.accel_noise,
       options.max_accel_noise,
       "accelerometer_noise_density",
       "estimator.imu.accel_noise_scale",
       "estimator.imu.max_accel_noise");
  return warnings;
}

Vector3d RateAtEnd(const ImuLink& link, const ImuBias& bias) {
  const std::vector<ImuSample>& samples = link.measured.samples();
  return samples.empty() ? Vector3d(Vector3d::Zero()) : Vector3d(samples.back().gyro - bias.b_g);
}

Matrix<15, 15> ImuSqrtInfo(const ImuPreintegration& measured, const BiasWalk& walk) {
  // Scaled to unit diagonal first: the variances span ten orders of magnitude.
  const Vector<9> sigma = measured.Covariance().diagonal().cwiseMax(1e-30).cwiseSqrt();
  const Vector<9> inv_sigma = sigma.cwiseInverse();
  const Matrix<9, 9> correlation =
      inv_sigma.asDiagonal() * measured.Covariance() * inv_sigma.asDiagonal();
  const Matrix<9, 9> L = (correlation + 1e-12 * Matrix<9, 9>::Identity()).llt().matrixL();

  Matrix<15, 15> W = Matrix<15, 15>::Zero();
  W.block<9, 9>(0, 0) =
      L.triangularView<Eigen::Lower>().solve(Matrix<9, 9>(inv_sigma.asDiagonal()));
  const double root_T = std::sqrt(std::max(measured.dt(), 1e-6));
  W.block<3, 3>(9, 9) = Matrix3d::Identity() / (walk.gyro * root_T);
  W.block<3, 3>(12, 12) = Matrix3d::Identity() / (walk.accel * root_T);
  return W;
}

}  // namespace facet
