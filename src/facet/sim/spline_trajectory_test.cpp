// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/spline_trajectory.h"

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/imu/preintegration.h"
#include "facet/sim/euroc_csv.h"
#include "facet/testing/data_dir.h"

namespace facet {
namespace {

constexpr Duration k1kHz{1'000'000};
constexpr Duration k200Hz{5'000'000};

/// Deviation (rad, m, m/s) of the integrated ideal IMU from the trajectory after 10 s. At 200 Hz
/// the midpoint rule itself is off by up to 3 mm; its error falls with the square of the step.
Vector3d IntegrationError(const SplineTrajectory& trajectory, double start_s, Duration step) {
  const Timestamp begin = trajectory.begin() + FromSeconds(start_s);
  std::vector<ImuSample> samples;
  for (Timestamp t = begin; t <= begin + FromSeconds(10); t = t + step) {
    samples.push_back(trajectory.IdealImuAt(t));
  }
  ImuPreintegration preintegration;
  preintegration.Integrate(samples);
  const NavState predicted = preintegration.Predict(trajectory.At(begin).state);
  const NavState truth = trajectory.At(predicted.t).state;
  return {LogSO3(truth.T_WB.q.conjugate() * predicted.T_WB.q).norm(),
          (truth.T_WB.p - predicted.T_WB.p).norm(),
          (truth.v_WB - predicted.v_WB).norm()};
}

TEST(SplineTrajectoryTest, DerivativesMatchDifferences) {
  const SplineTrajectory trajectory = SplineTrajectory::Fit(MakeFlight(10, 1));
  constexpr Duration h{100'000};
  for (double s : {0.01, 1.2345, 3.3, 7.0, 9.99}) {
    const Timestamp t = trajectory.begin() + FromSeconds(s);
    const TrajectoryPoint a = trajectory.At(t - h), b = trajectory.At(t + h), x = trajectory.At(t);
    const double dt = 2 * ToSeconds(h);
    EXPECT_LT(((b.state.T_WB.p - a.state.T_WB.p) / dt - x.state.v_WB).norm(), 1e-6);
    EXPECT_LT(((b.state.v_WB - a.state.v_WB) / dt - x.a_W).norm(), 1e-5);
    EXPECT_LT((LogSO3(a.state.T_WB.q.conjugate() * b.state.T_WB.q) / dt - x.w_B).norm(), 1e-6);
  }
}

TEST(SplineTrajectoryTest, PassesThroughSmoothPoses) {
  const auto flight = MakeFlight(12, 2);
  const SplineTrajectory trajectory = SplineTrajectory::Fit(flight);
  EXPECT_EQ(trajectory.begin(), flight.front().t);
  EXPECT_EQ(trajectory.end(), flight.back().t);
  for (const NavState& state : flight) {
    const NavState fitted = trajectory.At(state.t).state;
    ASSERT_LT((fitted.T_WB.p - state.T_WB.p).norm(), 1e-4);
    ASSERT_LT(LogSO3(fitted.T_WB.q.conjugate() * state.T_WB.q).norm(), 1e-4);
  }
  EXPECT_THROW(trajectory.At(trajectory.end() + Duration{1}), CheckError);
}

TEST(SplineTrajectoryTest, IntegratedImuReproducesAMadeUpFlight) {
  for (std::uint64_t seed : {1, 2, 3}) {
    const SplineTrajectory trajectory = SplineTrajectory::Fit(MakeFlight(12, seed));
    const Vector3d error = IntegrationError(trajectory, 1, k1kHz);
    EXPECT_LT(error(0), 1e-6);
    EXPECT_LT(error(1), 1e-4);
    EXPECT_LT(error(2), 2e-5);
    EXPECT_LT(IntegrationError(trajectory, 1, k200Hz)(1), 2e-3);
  }
}

class RealFlightTest : public ::testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Euroc,
                         RealFlightTest,
                         ::testing::Values("V1_01_easy", "V1_02_medium", "MH_05_difficult"));

TEST_P(RealFlightTest, SplineIsCloseToTheTruthAndToTheRealImu) {
  const std::string name = std::string("euroc_flights/") + GetParam();
  const auto folder = testing::DataDir(name);
  if (!folder) GTEST_SKIP() << testing::MissingData(name);
  const auto truth = LoadGroundTruthCsv(*folder / "groundtruth.csv");
  const SplineTrajectory trajectory = SplineTrajectory::Fit(truth);
  double squares = 0;
  for (const NavState& state : truth) {
    squares += (trajectory.At(state.t).state.T_WB.p - state.T_WB.p).squaredNorm();
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(truth.size())), 2e-3) << "m";

  // Means over 50 ms, without the vibration of the real vehicle.
  const auto imu = LoadImuCsv(*folder / "imu.csv");
  Vector<6> sum = Vector<6>::Zero(), error = Vector<6>::Zero();
  int count = 0, num_means = 0;
  for (const ImuSample& sample : imu) {
    if (sample.t < trajectory.begin() || sample.t > trajectory.end()) continue;
    const ImuSample ideal = trajectory.IdealImuAt(sample.t);
    sum.head<3>() += sample.gyro - truth.front().bias.b_g - ideal.gyro;
    sum.tail<3>() += sample.accel - truth.front().bias.b_a - ideal.accel;
    if (++count < 10) continue;
    error += (sum / count).cwiseAbs2();
    sum.setZero();
    count = 0;
    ++num_means;
  }
  error = (error / num_means).cwiseSqrt();
  EXPECT_LT(error.head<3>().maxCoeff(), 0.05) << "rad/s";
  EXPECT_LT(error.tail<3>().maxCoeff(), 0.6) << "m/s^2";

  for (double start : {1.0, 20.0, 50.0}) {
    EXPECT_LT(IntegrationError(trajectory, start, k1kHz)(1), 3e-4) << "from " << start << " s";
    EXPECT_LT(IntegrationError(trajectory, start, k200Hz)(1), 5e-3) << "from " << start << " s";
  }
}

}  // namespace
}  // namespace facet
