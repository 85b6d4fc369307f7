// SPDX-License-Identifier: BSD-2-Clause
// A camera that stays in one place hears the same spots of the same planes again and again, each
// with the error that it always has. That must not make the planes better known than they are.
#include <cmath>

#include "consistency_run.h"
#include "oracle_planes.h"
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/calibration/calibration_error.h"

namespace facet {
namespace {

constexpr double kDuration_s = 240;
constexpr int kNumSeeds = 2;

// What images of a simulated room show: most of an error lasts as long as its track.
ConsistencyOptions Options() {
  ConsistencyOptions options;
  options.simulator.pixel_sigma = 0.1;
  options.simulator.slide_sigma_px = 0.15;
  options.simulator.match_sigma_px = 0.06;
  options.simulator.mean_track_life_s = 30;
  options.simulator.roughness_m = options.estimator.solver.plane_sigma_m;
  return options;
}

struct MeanNees {
  double yaw = 0, normal = 0, offset = 0;
};

MeanNees Fly(const Scenario& scenario) {
  const ConsistencyOptions options = Options();
  MeanNees sum;
  double num_frames = 0, num_planes = 0;
  for (int seed = 1; seed <= kNumSeeds; ++seed) {
    const SimulatedRun run = Simulate(scenario, options, static_cast<std::uint64_t>(seed));
    const ConsistencyRun flown =
        RunConsistency(run, options, false, OraclePlanes(run, OraclePlaneOptions()));
    EXPECT_EQ(flown.num_resets, 0);
    for (const FrameError& frame : flown.frames) {
      const Vector3d up_B = frame.R_WB.transpose() * Vector3d::UnitZ();
      const double error = up_B.dot(frame.error.head<3>());
      sum.yaw += error * error / up_B.dot(frame.covariance.topLeftCorner<3, 3>() * up_B);
      ++num_frames;
    }
    for (const PlaneError& plane : flown.planes) {
      const Vector2d slope = plane.error.head<2>();
      sum.normal += slope.dot(plane.covariance.topLeftCorner<2, 2>().inverse() * slope) / 2;
      sum.offset += plane.error.z() * plane.error.z() / plane.covariance(2, 2);
      ++num_planes;
    }
  }
  EXPECT_GT(num_frames, 0.9 * kNumSeeds * kDuration_s * 20);
  EXPECT_GT(num_planes, 2 * kNumSeeds * kDuration_s * 4) << "two planes in each keyframe";
  return {sum.yaw / num_frames, sum.normal / num_planes, sum.offset / num_planes};
}

TEST(HoverTest, PlanesAreNotBetterKnownThanTheirErrorsThatLast) {
  for (const Scenario& scenario : HoverScenarios(kDuration_s)) {
    const MeanNees nees = Fly(scenario);
    EXPECT_LT(nees.yaw, 2) << scenario.name;
    EXPECT_LT(nees.normal, 2.5) << scenario.name;
    EXPECT_LT(nees.offset, 2.5) << scenario.name;
    EXPECT_GT(nees.normal, 0.2) << scenario.name << ": too modest";
  }
}

// Rest shows nothing of the calibration, which is right: what changes without end was learnt from
// noise.
TEST(HoverTest, AtRestTheCalibrationStays) {
  ConsistencyOptions options;
  options.simulator.pixel_sigma = 0.2;
  options.simulator.mean_track_life_s = 30;
  const Scenario rest = HoverScenarios(kDuration_s).back();
  ASSERT_EQ(rest.name, "rest");
  constexpr int kNumRestSeeds = 6;  // 0.027 px from one to the next
  double disparity_px = 0;
  for (std::uint64_t seed = 1; seed <= kNumRestSeeds; ++seed) {
    const SimulatedRun run = Simulate(rest, options, seed);
    const ConsistencyRun flown = RunConsistency(run, options, false);
    ASSERT_TRUE(flown.calibration);
    disparity_px +=
        CompareCalibrations(*flown.calibration, run.rig).disparity_mean_px / kNumRestSeeds;
  }
  EXPECT_NEAR(disparity_px, 0, 0.025) << "at infinity";
}

}  // namespace
}  // namespace facet
