// SPDX-License-Identifier: BSD-2-Clause
// On-manifold IMU preintegration (Forster et al., TRO 2017; docs/math.md, section 2), midpoint
// rule. Order of every 9-vector and 9x9 matrix here: theta, p, v.
#pragma once

#include <span>
#include <vector>

#include "facet/imu/imu_motion.h"

namespace facet {

/// What one integration assumes of the IMU, noise after inflation, and of the world; see ImuOptions
/// in the estimator.
struct ImuParameters {
  double gyro = 1.6968e-4;    ///< rad/s/sqrt(Hz)
  double accel = 2.0e-3;      ///< m/s^2/sqrt(Hz)
  double integration = 1e-8;  ///< m/sqrt(s): keeps the position covariance regular
  /// What happened inside a hole between two samples is only guessed from its ends: the mean rate
  /// and acceleration over the hole get these extra standard deviations. EuRoC flights with
  /// artificial holes of 25-200 ms: up to 0.07 rad/s and 0.9 m/s^2 rms per axis.
  double gyro_in_gap = 0.1;   ///< rad/s
  double accel_in_gap = 1.0;  ///< m/s^2
  /// Magnitude [m/s^2]. Not part of the integral: Predict adds it.
  double gravity = kGravity;

  Vector3d g_W() const { return {0, 0, -gravity}; }
};

/// How much the steps between some samples are trusted. It stays with them when an interval is
/// integrated again or joined to another one.
struct StepNoise {
  double scale = 1;           ///< multiplies the densities of ImuParameters
  double max_step_s = 0.021;  ///< a longer step is a hole
};

/// The motion between two stamps as the IMU saw it (see ImuMotion), with its covariance and how it
/// depends on biases and scale. Not thread-safe.
///
/// The samples are kept, so that the integral can be redone about another bias and two neighbouring
/// intervals can be joined exactly.
class ImuPreintegration {
 public:
  ImuPreintegration() = default;
  /// `gyro_scale`: by what share the gyroscope reads too much on each of its axes.
  ImuPreintegration(const ImuBias& bias,
                    const ImuParameters& parameters,
                    const Vector3d& gyro_scale = Vector3d::Zero())
      : bias_(bias), gyro_scale_(gyro_scale), parameters_(parameters) {}

  /// Extends the interval by the samples, with the same noise for each of their steps. CHECKs that
  /// they are in order of time and that the first one has the stamp of the last one that is already
  /// there (intervals share their end samples; see ImuBuffer::Between). Samples with the stamp of
  /// their predecessor add nothing.
  void Integrate(std::span<const ImuSample> samples, const StepNoise& noise = {});

  /// Extends the interval by the samples of `next`, each step with the noise that it has there.
  /// CHECKs as Integrate does.
  void Append(const ImuPreintegration& next);

  /// Integrates the stored samples again about another bias and scale.
  void Reintegrate(const ImuBias& bias, const Vector3d& gyro_scale);

  /// Length of the interval [s].
  double dt() const { return motion_.dt_s; }
  const ImuBias& bias() const { return bias_; }
  const Vector3d& gyro_scale() const { return gyro_scale_; }
  const std::vector<ImuSample>& samples() const { return samples_; }
  /// Gravity of the world in which the IMU moved.
  Vector3d g_W() const { return parameters_.g_W(); }
  const Quaterniond& dR() const { return motion_.dR; }
  const Vector3d& dp() const { return motion_.dp; }
  const Vector3d& dv() const { return motion_.dv; }

  /// Covariance of (theta, p, v), theta perturbing dR on the right. Zero for an empty interval.
  const Matrix<9, 9>& Covariance() const { return covariance_; }

  /// d (theta, p, v) / d (b_g, b_a) at bias().
  const Matrix<9, 6>& BiasJacobian() const { return J_bias_; }

  /// d (theta, p, v) / d (scale of the gyroscope) at gyro_scale().
  const Matrix<9, 3>& ScaleJacobian() const { return J_scale_; }

  /// State at the end of the interval, from the state at its start, with the biases of `start`
  /// (first-order correction) and gyro_scale(). Its stamp is the start's plus the length of the
  /// interval.
  NavState Predict(const NavState& start) const;

 private:
  void Add(const ImuSample& sample, const StepNoise& noise);
  void Step(const ImuSample& a, const ImuSample& b, const StepNoise& noise);

  ImuBias bias_;
  Vector3d gyro_scale_ = Vector3d::Zero();
  ImuParameters parameters_;
  std::vector<ImuSample> samples_;
  std::vector<StepNoise> step_noise_;  // of the step that ends at the sample of the same index
  ImuMotion motion_;
  Matrix<9, 9> covariance_ = Matrix<9, 9>::Zero();
  Matrix<9, 6> J_bias_ = Matrix<9, 6>::Zero();
  Matrix<9, 3> J_scale_ = Matrix<9, 3>::Zero();
};

}  // namespace facet
