// SPDX-License-Identifier: BSD-2-Clause
// What the states of the whole back half claim to know with right and wrong calibrations, on
// simulated features.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/pipeline/simulated_front.h"
#include "facet/testing/wrong_rigs.h"

namespace facet {
namespace {

constexpr double kDuration_s = 25;

// Position and heading of the first pose are those of the world; it may not be level.
SE3 AlignLevel(const SE3& estimate, const SE3& truth) {
  const double yaw = LogSO3(estimate.q * truth.q.conjugate()).z();
  const Quaterniond q = ExpSO3(Vector3d(0, 0, yaw));
  return {q, estimate.p - q * truth.p};
}

using RigChange = std::function<StereoRig(const StereoRig&)>;

RigChange Baseline(double factor) {
  return [factor](const StereoRig& rig) { return testing::WithBaseline(rig, factor); };
}

RigChange FocalLengths(double factor) {
  return [factor](const StereoRig& rig) { return testing::WithFocalLengths(rig, factor); };
}

// `given`: what the estimator takes for the rig.
double PositionNeesOfFlight(std::uint64_t seed, const RigChange& given, const VioOptions& options) {
  FeatureSimulatorOptions simulated;
  simulated.max_tracks = 150;
  simulated.pixel_sigma = 0.1;
  simulated.duration_s = kDuration_s;
  SimulatedRun run = SimulateFeatures(
      SplineTrajectory::Fit(MakeFlight(kDuration_s, seed)), EurocRig(), simulated, seed);
  run.rig = given(run.rig);

  std::size_t frame = 0;
  int num_states = 0;
  double nees = 0;
  std::optional<SE3> T_W_truth;
  testing::RunOnFeatures(run, options, [&](const VioOutput& output) {
    const SE3& truth = run.truth[frame++].T_WB;
    if (!output.has_pose) return;
    if (!T_W_truth) T_W_truth = AlignLevel(output.state.T_WB, truth);
    const Vector3d error = output.state.T_WB.p - *T_W_truth * truth.p;
    nees += error.cwiseQuotient(output.sigma_p).squaredNorm() / 3;
    ++num_states;
  });
  return nees / num_states;
}

// Mean of a few flights.
double PositionNees(const RigChange& given, bool check_calibration = true) {
  constexpr int kFlights = 3;
  VioOptions options;
  options.mesh.enabled = false;
  options.check_calibration = check_calibration;
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= kFlights; ++seed)
    sum += PositionNeesOfFlight(seed, given, options);
  return sum / kFlights;
}

TEST(HonestCovarianceTest, IsThatOfTheErrorsWithTheRightCalibration) {
  const double nees = PositionNees(Baseline(1));
  EXPECT_LT(nees, 2);
  EXPECT_GT(nees, 0.3);
}

TEST(HonestCovarianceTest, CoversABaselineThatIsWrong) {
  const double doubted = PositionNees(Baseline(1.02));
  EXPECT_LT(doubted, 4) << "most of it in the seconds before anything is measured";
  EXPECT_GT(PositionNees(Baseline(1.02), false), 4 * doubted);
}

TEST(HonestCovarianceTest, CoversFocalLengthsThatAreWrong) {
  EXPECT_LT(PositionNees(FocalLengths(0.99)), 3);
  EXPECT_LT(PositionNees(FocalLengths(1.01)), 3);
}

struct Nees {
  double position = 0, orientation = 0;
};

// Of the two seconds after the IMU has been silent for so long, in the middle of the fastest turn
// of the flight; it is that moment that is taken for right.
Nees NeesAfterAHole(std::uint64_t seed, double hole_s) {
  constexpr double kShort_s = 12;
  FeatureSimulatorOptions simulated;
  simulated.pixel_sigma = 0.1;
  simulated.duration_s = kShort_s;
  SimulatedRun run = SimulateFeatures(
      SplineTrajectory::Fit(MakeFlight(kShort_s, seed)), EurocRig(), simulated, seed);
  const Timestamp begin = run.truth.front().t;
  const auto is_early = [&](const ImuSample& sample) {
    return sample.t - begin < FromSeconds(4) || sample.t - begin > FromSeconds(9);
  };
  const Timestamp fastest =
      std::max_element(run.imu.begin(), run.imu.end(), [&](const auto& a, const auto& b) {
        return (is_early(a) ? 0 : a.gyro.norm()) < (is_early(b) ? 0 : b.gyro.norm());
      })->t;
  const Timestamp from = fastest - FromSeconds(hole_s / 2), to = from + FromSeconds(hole_s);
  std::erase_if(run.imu, [&](const ImuSample& sample) { return sample.t > from && sample.t < to; });

  VioOptions options;
  options.mesh.enabled = false;
  std::size_t frame = 0;
  int num_states = 0;
  Nees nees;
  std::optional<SE3> T_W_truth;
  testing::RunOnFeatures(run, options, [&](const VioOutput& output) {
    const NavState& truth = run.truth[frame++];
    if (!output.has_pose || truth.t > to + FromSeconds(2)) return;
    if (truth.t < from) T_W_truth = AlignLevel(output.state.T_WB, truth.T_WB);
    if (truth.t < to || !T_W_truth) return;
    const SE3 expected = *T_W_truth * truth.T_WB;
    const Vector3d off_m = output.state.T_WB.p - expected.p;
    const Vector3d off = LogSO3(expected.q.conjugate() * output.state.T_WB.q);
    nees.position += off_m.cwiseQuotient(output.sigma_p).squaredNorm() / 3;
    nees.orientation += off.cwiseQuotient(output.sigma_theta).squaredNorm() / 3;
    ++num_states;
  });
  EXPECT_GE(num_states, 30) << seed;
  return {nees.position / num_states, nees.orientation / num_states};
}

TEST(HonestCovarianceTest, AHoleOfTheImuWhileTurningIsCovered) {
  constexpr int kFlights = 4;
  for (const double hole_s : {0.1, 0.2, 0.3}) {
    Nees mean;
    for (std::uint64_t seed = 1; seed <= kFlights; ++seed) {
      const Nees nees = NeesAfterAHole(seed, hole_s);
      mean.position += nees.position / kFlights;
      mean.orientation += nees.orientation / kFlights;
    }
    EXPECT_LT(mean.position, 2) << hole_s;
    EXPECT_LT(mean.orientation, 2) << hole_s;
  }
}

}  // namespace
}  // namespace facet
