// SPDX-License-Identifier: BSD-2-Clause
#include "facet/imu/preintegration.h"

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/base/random.h"
#include "facet/geometry/so3.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

constexpr double kRate = 200.0;

/// A motion with closed-form derivatives: p_W = p0 + sum of sines; R_WB = Exp(w0 t + w1 sin(s t))
/// about one axis, so that the body rate is exact.
struct AnalyticMotion {
  Vector3d amplitude{0.8, -0.5, 0.3}, frequency{2.1, 1.3, 2.9}, axis{0.267261, -0.534522, 0.801784};
  double rate = 0.7, swing = 0.6, swing_frequency = 3.0;

  NavState At(double t) const {
    NavState state;
    state.t = Timestamp{} + FromSeconds(t);
    state.T_WB.q = ExpSO3(axis.normalized() * (rate * t + swing * std::sin(swing_frequency * t)));
    const Eigen::Array3d phase = frequency.array() * t;
    state.T_WB.p = amplitude.array() * phase.sin();
    state.v_WB = amplitude.array() * frequency.array() * phase.cos();
    return state;
  }

  ImuSample ImuAt(double t) const {
    const Eigen::Array3d phase = frequency.array() * t;
    const Vector3d a_W = -amplitude.array() * frequency.array().square() * phase.sin();
    const Vector3d w_B =
        axis.normalized() * (rate + swing * swing_frequency * std::cos(swing_frequency * t));
    return {Timestamp{} + FromSeconds(t), w_B, At(t).T_WB.q.conjugate() * (a_W - GravityInWorld())};
  }

  std::vector<ImuSample> Samples(double t0, double t1, double rate_hz = kRate) const {
    std::vector<ImuSample> samples;
    const int n = static_cast<int>(std::lround((t1 - t0) * rate_hz));
    for (int i = 0; i <= n; ++i)
      samples.push_back(ImuAt(t0 + i / rate_hz));
    return samples;
  }
};

ImuPreintegration Integrated(const std::vector<ImuSample>& samples,
                             const ImuBias& bias = {},
                             const ImuParameters& noise = {}) {
  ImuPreintegration result(bias, noise);
  result.Integrate(samples);
  return result;
}

/// Deviation (theta, p, v) of a from b, theta on the right of b.
Vector<9> Difference(const ImuPreintegration& a, const ImuPreintegration& b) {
  Vector<9> d;
  d << LogSO3(b.dR().conjugate() * a.dR()), a.dp() - b.dp(), a.dv() - b.dv();
  return d;
}

Vector<9> Difference(const NavState& a, const NavState& b) {
  Vector<9> d;
  d << LogSO3(b.T_WB.q.conjugate() * a.T_WB.q), a.T_WB.p - b.T_WB.p, a.v_WB - b.v_WB;
  return d;
}

double PredictionError(double rate_hz) {
  const AnalyticMotion motion;
  const NavState end = Integrated(motion.Samples(0.4, 1.4, rate_hz)).Predict(motion.At(0.4));
  EXPECT_EQ(end.t, motion.At(1.4).t);
  return Difference(end, motion.At(1.4)).cwiseAbs().maxCoeff();
}

TEST(PreintegrationTest, ReproducesAnalyticMotionWithSecondOrderAccuracy) {
  EXPECT_LT(PredictionError(200), 1e-4);
  EXPECT_LT(PredictionError(2000), 1e-6);
  EXPECT_NEAR(PredictionError(200) / PredictionError(800), 16.0, 1.0);
}

TEST(PreintegrationTest, IsExactForConstantRateAtRestAndForFreeFall) {
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 40; ++i) {
    samples.push_back({Timestamp{} + FromSeconds(i / kRate), {0.1, -0.4, 0.9}, Vector3d::Zero()});
  }
  NavState start;
  start.v_WB = Vector3d(1, 2, 3);
  const NavState end = Integrated(samples).Predict(start);
  EXPECT_LT(LogSO3(end.T_WB.q.conjugate() * ExpSO3(0.2 * Vector3d(0.1, -0.4, 0.9))).norm(), 1e-12);
  EXPECT_LT((end.v_WB - Vector3d(1, 2, 3 - 0.2 * kGravity)).norm(), 1e-12);
  EXPECT_LT((end.T_WB.p - Vector3d(0.2, 0.4, 0.6 - 0.02 * kGravity)).norm(), 1e-12);
}

TEST(PreintegrationTest, PredictsWithTheGravityItIsGiven) {
  ImuParameters on_mars;
  on_mars.gravity = 3.71;
  ImuPreintegration fall({}, on_mars);
  std::vector<ImuSample> samples(2);
  for (ImuSample& weightless : samples)
    weightless.gyro = weightless.accel = Vector3d::Zero();
  samples[1].t = Timestamp{} + FromSeconds(2);
  fall.Integrate(samples);
  fall.Reintegrate({Vector3d::Zero(), Vector3d(0.1, 0, 0)}, Vector3d::Zero());
  fall.Reintegrate({}, Vector3d::Zero());
  const NavState end = fall.Predict(NavState());
  EXPECT_LT((end.v_WB - Vector3d(0, 0, -7.42)).norm(), 1e-12);
  EXPECT_LT((end.T_WB.p - Vector3d(0, 0, -7.42)).norm(), 1e-12);
}

TEST(PreintegrationTest, BiasJacobianMatchesNumericDerivative) {
  const auto samples = AnalyticMotion().Samples(0, 0.5);
  const ImuBias bias{Vector3d(0.01, -0.02, 0.03), Vector3d(-0.1, 0.2, 0.05)};
  const ImuPreintegration nominal = Integrated(samples, bias);
  const auto f = [&](const Vector<6>& d) {
    return Difference(Integrated(samples, {bias.b_g + d.head<3>(), bias.b_a + d.tail<3>()}),
                      nominal);
  };
  testing::ExpectJacobian<9, 6>(nominal.BiasJacobian(), f, 1e-8, 1e-4);
}

TEST(PreintegrationTest, ScaleJacobianMatchesNumericDerivative) {
  const auto samples = AnalyticMotion().Samples(0, 0.5);
  const ImuBias bias{Vector3d(0.01, -0.02, 0.03), Vector3d(-0.1, 0.2, 0.05)};
  const auto integrated = [&](const Vector3d& gyro_scale) {
    ImuPreintegration result(bias, {}, gyro_scale);
    result.Integrate(samples);
    return result;
  };
  const Vector3d gyro_scale(0.01, -0.02, 0.005);
  const ImuPreintegration nominal = integrated(gyro_scale);
  const auto f = [&](const Vector3d& d) { return Difference(integrated(gyro_scale + d), nominal); };
  testing::ExpectJacobian<9, 3>(nominal.ScaleJacobian(), f, 1e-8, 1e-4);
}

TEST(PreintegrationTest, PredictCorrectsForTheBiasToFirstOrder) {
  const AnalyticMotion motion;
  const auto samples = motion.Samples(0, 0.2);
  const ImuPreintegration nominal = Integrated(samples);
  NavState start = motion.At(0);
  start.bias = {Vector3d(2e-3, -1e-3, 3e-3), Vector3d(0.02, -0.03, 0.01)};
  const NavState corrected = nominal.Predict(start);
  const NavState exact = Integrated(samples, start.bias).Predict(start);
  const NavState ignored = [&] {
    NavState s = start;
    s.bias = {};
    return nominal.Predict(s);
  }();
  EXPECT_LT(Difference(corrected, exact).norm(), 5e-6);
  EXPECT_GT(Difference(ignored, exact).norm(), 1e-3);
}

TEST(PreintegrationTest, ReintegratingEqualsAFreshIntegration) {
  const auto samples = AnalyticMotion().Samples(0, 0.3);
  const ImuBias bias{Vector3d(0.02, 0.01, -0.03), Vector3d(0.3, -0.2, 0.1)};
  ImuPreintegration again = Integrated(samples);
  again.Reintegrate(bias, Vector3d::Zero());
  const ImuPreintegration fresh = Integrated(samples, bias);
  EXPECT_EQ(Difference(again, fresh).norm(), 0);
  EXPECT_EQ((again.Covariance() - fresh.Covariance()).norm(), 0);
  EXPECT_EQ((again.BiasJacobian() - fresh.BiasJacobian()).norm(), 0);
  EXPECT_EQ(again.dt(), fresh.dt());
  EXPECT_EQ(again.samples().size(), samples.size());
  EXPECT_EQ(again.bias().b_g, bias.b_g);
}

TEST(PreintegrationTest, JoinedIntervalsEqualOneInterval) {
  const auto samples = AnalyticMotion().Samples(0, 0.4);
  const auto middle = samples.begin() + 33;
  ImuPreintegration joined = Integrated({samples.begin(), middle + 1});
  joined.Append(Integrated({middle, samples.end()}));
  const ImuPreintegration one = Integrated(samples);
  EXPECT_EQ(Difference(joined, one).norm(), 0);
  EXPECT_EQ((joined.Covariance() - one.Covariance()).norm(), 0);
  EXPECT_EQ(joined.samples().size(), one.samples().size());
}

TEST(PreintegrationTest, EachStepKeepsItsNoiseWhenIntervalsAreJoinedOrIntegratedAgain) {
  const auto samples = AnalyticMotion().Samples(0, 0.3);
  const auto third = static_cast<std::ptrdiff_t>(samples.size() / 3);
  const auto a = samples.begin() + third, b = samples.begin() + 2 * third;
  ImuPreintegration outage;
  outage.Integrate(std::vector(a, b + 1), StepNoise{300});
  ImuPreintegration joined = Integrated({samples.begin(), a + 1});
  joined.Append(outage);
  joined.Integrate(std::vector(b, samples.end()));
  EXPECT_GT(joined.Covariance()(0, 0), 0.9 * outage.Covariance()(0, 0));
  EXPECT_EQ(Difference(joined, Integrated(samples)).norm(), 0) << "noise moves nothing";

  const Matrix<9, 9> before = joined.Covariance();
  joined.Reintegrate(ImuBias{}, Vector3d::Zero());
  EXPECT_EQ((joined.Covariance() - before).norm(), 0);
}

TEST(PreintegrationTest, ASlowSensorHasNoHoles) {
  std::vector<ImuSample> slow;
  const auto samples = AnalyticMotion().Samples(0, 0.5);
  for (std::size_t i = 0; i < samples.size(); i += 5)  // 40 Hz
    slow.push_back(samples[i]);
  ImuPreintegration as_holes, as_usual;
  as_holes.Integrate(slow, StepNoise{1, 0.021});
  as_usual.Integrate(slow, StepNoise{1, 0.04});
  EXPECT_GT(as_holes.Covariance()(0, 0), 100 * as_usual.Covariance()(0, 0));
  const double expected = Integrated(samples).Covariance()(0, 0);
  EXPECT_NEAR(as_usual.Covariance()(0, 0), expected, 0.01 * expected);
}

// Samples with white noise of variance density^2 * rate, as a real sensor's.
std::vector<ImuSample> WithNoise(std::vector<ImuSample> samples,
                                 const ImuParameters& noise,
                                 Rng& rng) {
  const double root_rate = std::sqrt(kRate);
  for (ImuSample& s : samples) {
    s.gyro += noise.gyro * root_rate * rng.Normal3();
    s.accel += noise.accel * root_rate * rng.Normal3();
  }
  return samples;
}

TEST(PreintegrationTest, CovarianceAgreesWithMonteCarlo) {
  constexpr int kRuns = 6000;
  // Gyro noise large enough that its effect on velocity and position is seen beside the
  // accelerometer's.
  ImuParameters noise;
  noise.gyro = 1e-3;
  const auto samples = AnalyticMotion().Samples(0, 0.5);
  const ImuPreintegration truth = Integrated(samples, {}, noise);
  const Eigen::LLT<Matrix<9, 9>> llt(truth.Covariance());
  ASSERT_EQ(llt.info(), Eigen::Success);

  Rng rng(11);
  Matrix<9, 9> sample_covariance = Matrix<9, 9>::Zero();
  Vector<9> sum = Vector<9>::Zero();
  double nees = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Vector<9> e = Difference(Integrated(WithNoise(samples, noise, rng), {}, noise), truth);
    sum += e;
    sample_covariance += e * e.transpose() / kRuns;
    nees += llt.matrixL().solve(e).squaredNorm() / kRuns;
  }
  const Vector<9> sigma = truth.Covariance().diagonal().cwiseSqrt();
  for (int i = 0; i < 9; ++i) {
    // The standard error of a variance is sqrt(2 / 6000) = 1.8 %.
    EXPECT_NEAR(sample_covariance(i, i) / truth.Covariance()(i, i), 1.0, 0.06) << i;
    EXPECT_LT(std::abs(sum(i)) / std::sqrt(kRuns), 3.5 * sigma(i)) << i;
    for (int j = 0; j < i; ++j) {
      const double correlation = truth.Covariance()(i, j) / (sigma(i) * sigma(j));
      EXPECT_NEAR(sample_covariance(i, j) / (sigma(i) * sigma(j)), correlation, 0.06) << i << j;
    }
  }
  // 99 % interval of the mean of 6000 chi-square variables with 9 degrees of freedom.
  EXPECT_NEAR(nees, 9.0, 2.576 * std::sqrt(18.0 / kRuns));
}

TEST(PreintegrationTest, EmptyAndDegenerateInputsAddNothing) {
  ImuPreintegration p;
  p.Integrate({});
  EXPECT_EQ(p.dt(), 0);
  const auto samples = AnalyticMotion().Samples(0, 0.1);
  p.Integrate(std::span(samples).first(1));
  EXPECT_EQ(p.dt(), 0);
  EXPECT_EQ(p.dR().coeffs(), Quaterniond::Identity().coeffs());
  EXPECT_EQ(p.Covariance().norm(), 0);
  NavState start;
  start.t = Timestamp{77};
  EXPECT_EQ(p.Predict(start).t, start.t);
  EXPECT_EQ(p.samples().size(), 1u);

  std::vector<ImuSample> twice = samples;
  twice.insert(twice.begin() + 5, samples[5]);
  const ImuPreintegration once = Integrated(samples);
  EXPECT_EQ(Difference(Integrated(twice), once).norm(), 0);
  p.Integrate(samples);
  EXPECT_EQ(Difference(p, once).norm(), 0);
}

TEST(PreintegrationTest, RefusesSamplesThatDoNotFollow) {
  const auto samples = AnalyticMotion().Samples(0, 0.1);
  ImuPreintegration p = Integrated(samples);
  EXPECT_THROW(p.Integrate(samples), CheckError);
  std::vector<ImuSample> unsorted = samples;
  std::swap(unsorted[3], unsorted[4]);
  EXPECT_THROW(Integrated(unsorted), CheckError);
}

TEST(PreintegrationTest, AHoleIsBridgedWithLargerCovariance) {
  const AnalyticMotion motion;
  auto samples = motion.Samples(0, 0.4);
  const ImuPreintegration full = Integrated(samples);
  samples.erase(samples.begin() + 30, samples.begin() + 50);  // 0.105 s
  const ImuPreintegration holed = Integrated(samples);
  EXPECT_DOUBLE_EQ(holed.dt(), full.dt());
  const Vector<9> error = Difference(holed, full);
  const Eigen::LLT<Matrix<9, 9>> llt(holed.Covariance());
  ASSERT_EQ(llt.info(), Eigen::Success);
  EXPECT_LT(llt.matrixL().solve(error).squaredNorm(), 9.0);
  EXPECT_GT(holed.Covariance()(0, 0), 100 * full.Covariance()(0, 0));
}

TEST(PreintegrationTest, SurvivesAnAbsurdlyLongStep) {
  auto samples = AnalyticMotion().Samples(0, 0.01);
  samples.back().t = Timestamp{} + FromSeconds(3600);
  const ImuPreintegration p = Integrated(samples);
  EXPECT_TRUE(p.Covariance().allFinite());
  EXPECT_NEAR(p.dR().norm(), 1, 1e-12);
}

}  // namespace
}  // namespace facet
