// SPDX-License-Identifier: BSD-2-Clause
// Simulated features and IMU of made-up flights: a careful calibration is never refused, a wrong
// one is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/imu/imu_buffer.h"
#include "facet/plausibility/gyroscope_check.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"

namespace facet {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::size_t kFramesPerTurn = 4;

SimulatedRun Fly(std::uint64_t seed) {
  FeatureSimulatorOptions options;
  options.max_tracks = 70;
  options.outlier_share = 0.02;
  options.duration_s = 20;
  return SimulateFeatures(SplineTrajectory::Fit(MakeFlight(20, seed)), EurocRig(), options, seed);
}

std::vector<BearingPair> Pairs(const SimulatedRun& run,
                               const FrameObservations& first,
                               const FrameObservations& second) {
  std::unordered_map<LandmarkId, Vector3d> bearings;
  const CameraModel& camera = run.rig.cameras[0];
  for (const FeatureObservation& feature : first.features) {
    if (const auto f = camera.Unproject(feature.px_left)) bearings[feature.landmark] = *f;
  }
  std::vector<BearingPair> pairs;
  for (const FeatureObservation& feature : second.features) {
    const auto f = camera.Unproject(feature.px_left);
    const auto before = bearings.find(feature.landmark);
    if (f && before != bearings.end()) pairs.push_back({before->second, *f});
  }
  return pairs;
}

// What is said of the calibration in 20 s; the gyroscope's axes are multiplied by `factors`.
std::string Judge(const SimulatedRun& run, const Vector3d& mount_error, const Vector3d& factors) {
  GyroscopeCheck check((run.rig.T_BC[0].q * ExpSO3(mount_error)).normalized());
  ImuBuffer imu;
  for (const ImuSample& sample : run.imu)
    imu.Add(sample);
  for (std::size_t i = kFramesPerTurn; i < run.frames.size(); i += kFramesPerTurn) {
    const auto rotation = EstimateTwoViewRotation(
        Pairs(run, run.frames[i - kFramesPerTurn], run.frames[i]), 0.7 / 458);
    if (!rotation) continue;
    SharedTurn turn;
    turn.image = *rotation;
    const auto interval = imu.Between(
        run.truth[i - kFramesPerTurn].t, run.truth[i].t, Duration{21'000'000}, Duration{0});
    for (std::size_t k = 1; k < interval.samples.size(); ++k) {
      const double dt_s = ToSeconds(interval.samples[k].t - interval.samples[k - 1].t);
      turn.gyro_B += dt_s * factors.cwiseProduct(interval.samples[k].gyro);
      turn.duration_s += dt_s;
    }
    const std::string words = check.Add(turn);
    if (!words.empty()) return words;
  }
  return {};
}

TEST(SimulatedFlightsTest, ACarefulCalibrationIsNeverRefused) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Rng rng(seed);
    const Vector3d mount_error = 0.005 * rng.Normal3();
    EXPECT_THAT(Judge(Fly(seed), mount_error, Vector3d::Ones()), IsEmpty()) << seed;
  }
}

TEST(SimulatedFlightsTest, ANegatedAxisIsNamed) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SimulatedRun run = Fly(seed);
    EXPECT_THAT(Judge(run, Vector3d::Zero(), Vector3d(-1, 1, 1)), HasSubstr("axis x")) << seed;
    EXPECT_THAT(Judge(run, Vector3d::Zero(), Vector3d::Constant(57.3)), HasSubstr("deg/s")) << seed;
  }
}

}  // namespace
}  // namespace facet
