// SPDX-License-Identifier: BSD-2-Clause
// Steps against the integration that the estimator uses, against derivatives taken numerically, and
// against what many drawn noises do.
#include "facet/live/imu_step.h"

#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

constexpr double kStep_s = 0.005;

BiasWalk Walk() {
  return {ImuNoise{}, ImuOptions{}};
}

ImuSample SampleAt(double t) {
  return {Timestamp{1'000'000'000} + FromSeconds(t),
          Vector3d(0.8 * std::sin(7 * t), 0.5 + 0.3 * std::cos(5 * t), -0.9 * std::sin(3 * t + 1)),
          Vector3d(2 * std::sin(4 * t), -1.5 * std::cos(6 * t), 9.81 + std::sin(9 * t))};
}

std::vector<ImuSample> Samples(int num_steps) {
  std::vector<ImuSample> samples;
  for (int i = 0; i <= num_steps; ++i)
    samples.push_back(SampleAt(i * kStep_s));
  return samples;
}

// All of the state is uncertain, and all of it correlated.
ReckonedState Start() {
  ReckonedState start;
  start.x.t = SampleAt(0).t;
  start.x.T_WB = {ExpSO3({0.3, -0.2, 1.1}), Vector3d(1, -2, 0.5)};
  start.x.v_WB = Vector3d(0.4, -0.3, 0.2);
  start.x.bias = {Vector3d(0.01, -0.02, 0.015), Vector3d(0.1, 0.05, -0.08)};
  Rng rng(3);
  Matrix<15, 15> root;
  for (double& entry : root.reshaped())
    entry = rng.Normal();
  Vector<15> sigma;
  sigma << Vector<3>::Constant(0.01), Vector<3>::Constant(0.02), Vector<3>::Constant(0.03),
      Vector<3>::Constant(1e-3), Vector<3>::Constant(0.02);
  root = sigma.asDiagonal() * root;
  start.covariance = root * root.transpose();
  return start;
}

NavState Moved(NavState x, const Vector<15>& d) {
  x.T_WB.q = x.T_WB.q * ExpSO3(d.head<3>());
  x.T_WB.p += d.segment<3>(3);
  x.v_WB += d.segment<3>(6);
  x.bias.b_g += d.segment<3>(9);
  x.bias.b_a += d.segment<3>(12);
  return x;
}

Vector<15> Difference(const NavState& a, const NavState& b) {
  Vector<15> d;
  d << LogSO3(b.T_WB.q.conjugate() * a.T_WB.q), a.T_WB.p - b.T_WB.p, a.v_WB - b.v_WB,
      a.bias.b_g - b.bias.b_g, a.bias.b_a - b.bias.b_a;
  return d;
}

ReckonedState Advanced(ReckonedState state,
                       const std::vector<ImuSample>& samples,
                       const StepModel& model) {
  for (std::size_t i = 1; i < samples.size(); ++i)
    Advance(samples[i - 1], samples[i], model, state);
  return state;
}

double LargestRelative(const Matrix<15, 15>& a, const Matrix<15, 15>& b) {
  const Vector<15> sigma = b.diagonal().cwiseSqrt();
  const Matrix<15, 15> scale = sigma * sigma.transpose();
  return ((a - b).array() / scale.array()).abs().maxCoeff();
}

TEST(ImuStepTest, ManyStepsAreOnePreintegratedInterval) {
  const std::vector<ImuSample> samples = Samples(20);
  for (const double gyro_scale : {0.0, 0.01}) {
    StepModel model{{}, Walk()};
    model.gyro_scale.setConstant(gyro_scale);
    const ReckonedState start = Start(), end = Advanced(start, samples, model);
    ImuPreintegration interval(start.x.bias, model.parameters, model.gyro_scale);
    interval.Integrate(samples);
    const ReckonedState expected = Reckon(start, interval, model.walk);
    EXPECT_EQ(end.x.t, samples.back().t);
    EXPECT_LT(Difference(end.x, expected.x).norm(), 1e-12);
    // The walk of the biases on the way, which an interval adds at its end, is the difference.
    EXPECT_LT(LargestRelative(end.covariance, expected.covariance), 1e-4);
  }
}

TEST(ImuStepTest, CovarianceIsThatOfNumericDerivatives) {
  const std::vector<ImuSample> samples = Samples(10);
  const StepModel model{{}, Walk()};
  const ImuParameters& noise = model.parameters;
  const ReckonedState start = Start();
  ReckonedState state = start;
  Matrix<15, 15> expected = start.covariance;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const ReckonedState from = state;
    Advance(samples[i - 1], samples[i], model, state);
    const auto end_of = [&](const NavState& x, const Vector<6>& error) {
      ReckonedState moved{x, Matrix<15, 15>::Zero()};
      ImuSample a = samples[i - 1], b = samples[i];
      for (ImuSample* sample : {&a, &b}) {
        sample->gyro += error.head<3>();
        sample->accel += error.tail<3>();
      }
      Advance(a, b, model, moved);
      return Difference(moved.x, state.x);
    };
    const Matrix<15, 15> F = testing::NumericJacobian<15, 15>(
        [&](const Vector<15>& d) { return end_of(Moved(from.x, d), Vector<6>::Zero()); });
    const Matrix<15, 6> G = testing::NumericJacobian<15, 6>(
        [&](const Vector<6>& error) { return end_of(from.x, error); });
    Vector<6> variance;
    variance << Vector3d::Constant(noise.gyro * noise.gyro / kStep_s),
        Vector3d::Constant(noise.accel * noise.accel / kStep_s);
    expected = F * expected * F.transpose() + G * variance.asDiagonal() * G.transpose();
    expected.block<3, 3>(3, 3).diagonal().array() +=
        noise.integration * noise.integration * kStep_s;
    expected.block<3, 3>(9, 9).diagonal().array() += model.walk.gyro * model.walk.gyro * kStep_s;
    expected.block<3, 3>(12, 12).diagonal().array() +=
        model.walk.accel * model.walk.accel * kStep_s;
  }
  EXPECT_LT(LargestRelative(state.covariance, expected), 1e-7);
}

TEST(ImuStepTest, CovarianceIsThatOfDrawnNoise) {
  const std::vector<ImuSample> samples = Samples(20);
  StepModel model{{}, Walk()};
  model.parameters.gyro = 0.02;  // strong enough to be seen
  model.parameters.accel = 0.2;
  model.walk.gyro = model.walk.accel = 1e-9;
  ReckonedState start = Start();
  const Matrix<15, 15> root = start.covariance.llt().matrixL();
  const ReckonedState mean = Advanced(start, samples, model);
  Rng rng(1);
  Matrix<15, 15> sum = Matrix<15, 15>::Zero();
  constexpr int kNumDraws = 4000;
  const double gyro = model.parameters.gyro / std::sqrt(kStep_s);
  const double accel = model.parameters.accel / std::sqrt(kStep_s);
  const auto draw3 = [&] { return Vector3d(rng.Normal(), rng.Normal(), rng.Normal()); };
  for (int k = 0; k < kNumDraws; ++k) {
    Vector<15> d;
    for (double& entry : d)
      entry = rng.Normal();
    std::vector<ImuSample> noisy = samples;
    for (ImuSample& sample : noisy) {
      sample.gyro += gyro * draw3();
      sample.accel += accel * draw3();
    }
    ReckonedState drawn{Moved(start.x, root * d), Matrix<15, 15>::Zero()};
    const Vector<15> error = Difference(Advanced(drawn, noisy, model).x, mean.x);
    sum += error * error.transpose() / kNumDraws;
  }
  // Estimated correlations scatter by 1 / sqrt(4000); steps that share a sample count as
  // independent.
  EXPECT_LT(LargestRelative(mean.covariance, sum), 0.12);
}

TEST(ImuStepTest, AHoleIsAGuess) {
  const StepModel model{{}, Walk()};
  ReckonedState start = Start();
  start.covariance.setZero();
  ReckonedState near = start, far = start;
  ImuSample first = SampleAt(0), second = SampleAt(0);
  second.t = first.t + FromSeconds(0.02);
  Advance(first, second, model, near);
  second.t = first.t + FromSeconds(0.1);
  Advance(first, second, model, far);
  EXPECT_LT(std::sqrt(near.covariance(6, 6)), 0.001);
  EXPECT_NEAR(std::sqrt(far.covariance(6, 6)), 0.1, 0.03) << "1 m/s^2 for 0.1 s";
}

TEST(ImuStepTest, NoTimeNoChange) {
  const ReckonedState start = Start();
  ReckonedState end = start;
  Advance(SampleAt(0), SampleAt(0), {{}, Walk()}, end);
  EXPECT_EQ(end.covariance, start.covariance);
  EXPECT_EQ(end.x.T_WB.p, start.x.T_WB.p);
}

}  // namespace
}  // namespace facet
