// SPDX-License-Identifier: BSD-2-Clause
#include "facet/imu/imu_motion.h"

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/base/random.h"
#include "facet/geometry/so3.h"
#include "facet/imu/preintegration.h"

namespace facet {
namespace {

Vector3d RandomVector(Rng& rng) {
  return {rng.Normal(), rng.Normal(), rng.Normal()};
}

std::vector<ImuSample> ShakenSamples() {
  Rng rng(5);
  std::vector<ImuSample> samples;
  for (int i = 0; i < 40; ++i) {
    samples.push_back({Timestamp{} + FromSeconds(0.005 * i),
                       RandomVector(rng),
                       RandomVector(rng) + Vector3d(0, 0, 9.81)});
  }
  samples.insert(samples.begin() + 20, samples[20]);
  return samples;
}

TEST(ImuMotionTest, IsTheMeanOfPreintegration) {
  const std::vector<ImuSample> samples = ShakenSamples();
  const ImuBias bias{{0.01, -0.02, 0.03}, {0.1, 0.2, -0.3}};
  ImuPreintegration full(bias, ImuParameters());
  full.Integrate(samples);
  const ImuMotion motion = IntegrateMotion(samples, bias);
  EXPECT_EQ(motion.dt_s, full.dt());
  EXPECT_EQ(motion.dR.coeffs(), full.dR().coeffs());
  EXPECT_EQ(motion.dp, full.dp());
  EXPECT_EQ(motion.dv, full.dv());

  NavState start;
  start.T_WB = SE3(ExpSO3({0.3, -0.2, 0.9}), {1, 2, 3});
  start.v_WB = {0.5, -1, 0.2};
  start.bias = bias;
  const NavState expected = full.Predict(start), end = motion.From(start, full.g_W());
  EXPECT_EQ(end.T_WB.p, expected.T_WB.p);
  EXPECT_EQ(end.v_WB, expected.v_WB);
  EXPECT_EQ(end.T_WB.q.coeffs(), expected.T_WB.q.coeffs());
}

TEST(ImuMotionTest, NothingMovesWithoutAStep) {
  const std::vector<ImuSample> samples = ShakenSamples();
  for (const std::size_t num : {0, 1}) {
    const ImuMotion motion = IntegrateMotion(std::span(samples).first(num), {});
    EXPECT_EQ(motion.dt_s, 0);
    EXPECT_EQ(motion.dp, Vector3d::Zero());
    EXPECT_EQ(motion.dR.coeffs(), Quaterniond::Identity().coeffs());
  }
}

TEST(ImuMotionTest, SamplesOutOfOrderAreRefused) {
  std::vector<ImuSample> samples = ShakenSamples();
  std::swap(samples[3], samples[4]);
  EXPECT_THROW(IntegrateMotion(samples, {}), CheckError);
}

Vector<9> Moved(const StepMeasurement& measured, const NavState& start) {
  const MidpointStep step(start.T_WB.q, measured);
  Vector<9> end;
  end << LogSO3(step.q_end),
      start.T_WB.p + start.v_WB * measured.dt + 0.5 * measured.dt * measured.dt * step.acceleration,
      start.v_WB + measured.dt * step.acceleration;
  return end;
}

// Against central differences; angles on the right.
TEST(StepJacobianTest, IsTheDerivativeOfTheStep) {
  StepMeasurement measured{0.02, {1.5, -0.7, 2.1}, {3, -2, 9}, {1, -4, 11}};
  NavState start;
  start.T_WB = SE3(ExpSO3({0.4, 0.1, -0.6}), {0.3, 0.2, 0.1});
  start.v_WB = {0.7, -0.3, 0.2};
  const MidpointStep step(start.T_WB.q, measured);
  const StepJacobian jacobian(measured, step);
  const double h = 1e-6;
  const auto difference = [&](const auto& change) {
    const auto end = [&](double d) {
      StepMeasurement m = measured;
      NavState x = start;
      change(d, m, x);
      Vector<9> moved = Moved(m, x);
      moved.head<3>() = LogSO3(step.q_end.conjugate() * ExpSO3(moved.head<3>()));
      return moved;
    };
    return Vector<9>((end(h) - end(-h)) / (2 * h));
  };
  Matrix<9, 9> A, expected_A;
  A.setIdentity();
  jacobian.Propagate(A);
  Matrix<9, 6> expected_B;
  for (int k = 0; k < 3; ++k) {
    const Vector3d e = Vector3d::Unit(k);
    expected_A.col(k) = difference(
        [&](double d, StepMeasurement&, NavState& x) { x.T_WB.q = x.T_WB.q * ExpSO3(d * e); });
    expected_A.col(3 + k) =
        difference([&](double d, StepMeasurement&, NavState& x) { x.T_WB.p += d * e; });
    expected_A.col(6 + k) =
        difference([&](double d, StepMeasurement&, NavState& x) { x.v_WB += d * e; });
    expected_B.col(k) = difference([&](double d, StepMeasurement& m, NavState&) { m.w += d * e; });
    expected_B.col(3 + k) = difference([&](double d, StepMeasurement& m, NavState&) {
      m.a0 += d * e;
      m.a1 += d * e;
    });
  }
  EXPECT_LT((A - expected_A).norm(), 1e-8);
  EXPECT_LT((jacobian.B() - expected_B).norm(), 1e-8);
  const Matrix<6, 4> M = Matrix<6, 4>::Random();
  EXPECT_LT((jacobian.OfMeasurement(M) - jacobian.B() * M).norm(), 1e-14);
}

}  // namespace
}  // namespace facet
