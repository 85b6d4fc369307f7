// SPDX-License-Identifier: BSD-2-Clause
// Flights in a world with another gravity than Earth's.
#include <gtest/gtest.h>

#include "facet/estimator/vio_estimator.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/estimator/spoilt_run.h"

namespace facet {
namespace {

constexpr double kOnMars = 3.71;

SimulatedRun FlightWithGravity(double gravity) {
  FeatureSimulatorOptions options;
  options.max_tracks = 70;
  options.duration_s = 6;
  const SplineTrajectory trajectory = SplineTrajectory::Fit(MakeFlight(10, 2));
  SimulatedRun run = SimulateFeatures(trajectory, EurocRig(), options, 1);
  const Vector3d more_W = (gravity - kGravity) * Vector3d::UnitZ();
  for (ImuSample& sample : run.imu)
    sample.accel += trajectory.At(sample.t).state.T_WB.q.conjugate() * more_W;
  return run;
}

struct Flown {
  int num_poses = 0;
  double tilt_rad = 0;  // of the last pose
  double error_m = 0;   // of the last pose relative to the first one
};

Flown Fly(const SimulatedRun& run, double assumed_gravity) {
  EstimatorOptions options;
  options.imu.gravity_mps2 = assumed_gravity;
  VioEstimator estimator(run.rig, ImuNoise{}, options);
  const ImuBuffer imu = testing::ImuOf(run);
  StageTimes times;
  Flown flown;
  SE3 T_W_first, T_W_first_true;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const testing::EstimatorInput input = testing::InputOf(run, imu, i);
    const EstimatorResult result = estimator.AddFrame(input.observations, input.imu, times);
    if (!result.has_state) continue;
    const SE3 &T_WB = result.state.T_WB, &T_WB_true = run.truth[i].T_WB;
    if (flown.num_poses++ == 0) {
      T_W_first = T_WB;
      T_W_first_true = T_WB_true;
    }
    const Vector3d up_B = T_WB.q.conjugate() * Vector3d::UnitZ();
    flown.tilt_rad = (up_B - T_WB_true.q.conjugate() * Vector3d::UnitZ()).norm();
    flown.error_m =
        ((T_W_first.Inverse() * T_WB).p - (T_W_first_true.Inverse() * T_WB_true).p).norm();
  }
  return flown;
}

TEST(GravityTest, AFlightOnMarsIsAsGoodAsOneOnEarth) {
  for (const double gravity : {kGravity, kOnMars, 24.8}) {
    const Flown flown = Fly(FlightWithGravity(gravity), gravity);
    EXPECT_GE(flown.num_poses, 110) << gravity;
    EXPECT_LT(flown.tilt_rad, 0.02) << gravity;
    EXPECT_LT(flown.error_m, 0.06) << gravity;
  }
}

TEST(GravityTest, WithTheGravityOfAnotherWorldThereIsNoStart) {
  EXPECT_EQ(Fly(FlightWithGravity(kOnMars), kGravity).num_poses, 0);
  EXPECT_EQ(Fly(FlightWithGravity(kGravity), kOnMars).num_poses, 0);
}

TEST(GravityTest, ASlightlyWrongGravityCostsAccuracy) {
  const SimulatedRun run = FlightWithGravity(9.3);
  const double right = Fly(run, 9.3).error_m, wrong = Fly(run, kGravity).error_m;
  EXPECT_GT(wrong, 1.2 * right) << right;
}

}  // namespace
}  // namespace facet
