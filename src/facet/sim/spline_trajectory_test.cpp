// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/spline_trajectory.h"

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/geometry/so3.h"
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

/// Largest errors of rotation [rad] and velocity [m/s] gained over one second.
Vector2d ErrorOverASecond(const SplineTrajectory& path, const SplineTrajectory& truth) {
  Vector2d largest = Vector2d::Zero();
  for (double s = 3; s < 26; s += 0.1) {
    const Timestamp a = truth.begin() + FromSeconds(s), b = a + FromSeconds(1);
    const NavState pa = path.At(a).state, pb = path.At(b).state, ta = truth.At(a).state,
                   tb = truth.At(b).state;
    const Quaterniond turned = pa.T_WB.q.conjugate() * pb.T_WB.q;
    const Quaterniond turned_truly = ta.T_WB.q.conjugate() * tb.T_WB.q;
    const double rotation = LogSO3(turned.conjugate() * turned_truly).norm();
    const double velocity = (pb.v_WB - pa.v_WB - tb.v_WB + ta.v_WB).norm();
    largest = largest.cwiseMax(Vector2d(rotation, velocity));
  }
  return largest;
}

TEST(SplineTrajectoryTest, FollowsTheImuWhereRecordedPosesWander) {
  const SplineTrajectory truth = SplineTrajectory::Fit(MakeFlight(30, 1), {0.05, 1e-6});
  const ImuBias bias{Vector3d(0.01, -0.02, 0.03), Vector3d(0.1, 0.2, -0.1)};
  std::vector<NavState> recorded;
  std::vector<ImuSample> imu;
  for (Timestamp t = truth.begin(); t <= truth.end(); t = t + k200Hz) {
    const double s = ToSeconds(t - truth.begin());
    NavState state = truth.At(t).state;
    state.bias = bias;
    state.T_WB.q =
        state.T_WB.q * ExpSO3(3e-3 * Vector3d(std::sin(2 * s), std::cos(3 * s), std::sin(4 * s)));
    state.T_WB.p += 2e-3 * Vector3d(std::sin(9 * s), std::cos(12 * s), std::sin(15 * s));
    recorded.push_back(state);
    ImuSample sample = truth.IdealImuAt(t);
    sample.gyro += bias.b_g;
    sample.accel += bias.b_a;
    imu.push_back(sample);
  }
  const Vector2d poses_only = ErrorOverASecond(SplineTrajectory::Fit(recorded), truth);
  const SplineTrajectory fitted = SplineTrajectory::FitWithImu(recorded, imu);
  const Vector2d with_imu = ErrorOverASecond(fitted, truth);
  EXPECT_LT(with_imu(0), 0.1 * poses_only(0));
  EXPECT_LT(with_imu(1), 0.3 * poses_only(1));
  for (const NavState& state : recorded)
    EXPECT_LT((fitted.At(state.t).state.T_WB.p - state.T_WB.p).norm(), 0.01);
}

TEST(SplineTrajectoryTest, MovedToAnotherWorld) {
  const SplineTrajectory path = SplineTrajectory::Fit(MakeFlight(5, 1));
  const SE3 T_NW(ExpSO3(Vector3d(0.1, 0.2, 0.3)), Vector3d(1, 2, 3));
  const SplineTrajectory moved = path.MovedBy(T_NW);
  const Timestamp t = path.begin() + FromSeconds(2.345);
  const TrajectoryPoint a = path.At(t), b = moved.At(t);
  EXPECT_LT((b.state.T_WB.p - T_NW * a.state.T_WB.p).norm(), 1e-12);
  EXPECT_LT(LogSO3(b.state.T_WB.q.conjugate() * T_NW.q * a.state.T_WB.q).norm(), 1e-12);
  EXPECT_LT((b.a_W - T_NW.q * a.a_W).norm(), 1e-10);
  EXPECT_LT((b.w_B - a.w_B).norm(), 1e-12);
}

class RealFlightTest : public ::testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Euroc,
                         RealFlightTest,
                         ::testing::Values("V1_01_easy", "V1_02_medium", "MH_05_difficult"));

/// Root mean square angle between what the gyroscope and the path turned in 5 s, over the record.
double GyroMisfit(const SplineTrajectory& path,
                  const std::vector<NavState>& truth,
                  const std::vector<ImuSample>& imu) {
  double squares = 0;
  int count = 0;
  std::size_t state = 0;
  for (std::size_t i = 0; i + 1001 < imu.size(); i += 1000) {
    const Timestamp a = imu[i].t, b = imu[i + 1000].t;
    if (a < path.begin() || b > path.end()) continue;
    while (state + 1 < truth.size() && truth[state + 1].t <= a)
      ++state;
    ImuPreintegration turned(truth[state].bias, ImuParameters());
    turned.Integrate(std::span(imu).subspan(i, 1001));
    const Quaterniond of_path = path.At(a).state.T_WB.q.conjugate() * path.At(b).state.T_WB.q;
    squares += LogSO3(of_path.conjugate() * turned.dR()).squaredNorm();
    ++count;
  }
  return std::sqrt(squares / count);
}

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

  // What the gyroscope turned in 5 s, against both paths.
  const SplineTrajectory with_imu = SplineTrajectory::FitWithImu(truth, imu);
  const double misfit = GyroMisfit(with_imu, truth, imu);
  EXPECT_LT(misfit, 1.5e-3) << "rad";
  EXPECT_LT(misfit, 0.6 * GyroMisfit(trajectory, truth, imu));

  for (double start : {1.0, 20.0, 50.0}) {
    EXPECT_LT(IntegrationError(trajectory, start, k1kHz)(1), 3e-4) << "from " << start << " s";
    EXPECT_LT(IntegrationError(trajectory, start, k200Hz)(1), 5e-3) << "from " << start << " s";
  }
}

}  // namespace
}  // namespace facet
