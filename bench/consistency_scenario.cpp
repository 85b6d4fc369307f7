// SPDX-License-Identifier: BSD-2-Clause
#include "consistency_scenario.h"

#include <cmath>
#include <cstdio>
#include <optional>

#include "facet/sim/euroc_csv.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/flight.h"
#include "facet/testing/data_dir.h"

namespace facet {

namespace {

struct Stretch {
  const char* flight;
  double start_s;  // after take-off, at the flight's usual speed
};
constexpr Stretch kStretches[] = {
    {"V1_01_easy", 40.0}, {"V1_02_medium", 20.0}, {"MH_05_difficult", 22.0}};

// The ground truth is known to about this; a wide prior would count the gauge as uncertain.
constexpr double kOriginSigma = 1e-4;

}  // namespace

ConsistencyOptions::ConsistencyOptions() {
  estimator.imu.gyro_noise_scale = estimator.imu.accel_noise_scale = 1.0;
  estimator.imu.gyro_walk_scale = estimator.imu.accel_walk_scale = 1.0;
  estimator.calibration.gyro_misalignment_deg = 0;  // nor has the simulated IMU any
  estimator.start.sigma_position = estimator.start.sigma_yaw = kOriginSigma;
  // The runner hides right observations as a front end does: after the start, keyframes only.
  simulator.right_on_every_frame = true;
}

std::vector<Scenario> RecordedScenarios(const std::filesystem::path& folder, double duration_s) {
  std::vector<Scenario> scenarios;
  for (const Stretch& stretch : kStretches) {
    const std::vector<NavState> truth =
        LoadGroundTruthCsv(folder / stretch.flight / "groundtruth.csv");
    scenarios.push_back(
        {stretch.flight, SplineTrajectory::Fit(truth), stretch.start_s, duration_s, {}});
  }
  return scenarios;
}

std::vector<Scenario> MadeUpScenarios(double duration_s) {
  constexpr double kMargin = 1.0;
  std::vector<Scenario> scenarios;
  for (const int seed : {1, 2, 3}) {
    const std::vector<NavState> poses = MakeFlight(duration_s + kMargin, seed);
    scenarios.push_back(
        {"made-up " + std::to_string(seed), SplineTrajectory::Fit(poses), 0, duration_s, {}});
  }
  return scenarios;
}

std::vector<Scenario> CorridorScenarios(double duration_s) {
  constexpr SplineOptions kSpline{0.05, 1e-6};  // made-up poses have no noise to be smoothed
  CorridorOptions corridor;
  FlightOptions walk;
  walk.duration_s = duration_s;
  walk.lead_s = 1;
  const double lap_m = 2 * (corridor.length_m + corridor.depth_m);
  const int laps = 1 + static_cast<int>(1.5 * duration_s / lap_m);  // at most 1.3 m/s
  const auto poses = MakeFlightPoses(FlightKind::kWalk, CorridorWalk(corridor, laps), walk);
  const SplineTrajectory trajectory = SplineTrajectory::Fit(poses, kSpline);
  CorridorOptions panels = corridor;
  panels.cupboard_depth_m = 0.1;
  return {{"corridor", trajectory, 0.5, duration_s, corridor},
          {"corridor_panels", trajectory, 0.5, duration_s, panels}};
}

std::vector<Scenario> HoverScenarios(double duration_s) {
  constexpr SplineOptions kSpline{0.05, 1e-6};  // made-up poses have no noise to be smoothed
  constexpr double kSetDown_s = 10, kSettling_s = 1;
  const std::vector<Vector3d> route = {Vector3d(0, 0, 1.2), Vector3d(1, 0, 1.2)};
  FlightOptions flight;
  flight.duration_s = duration_s;
  flight.lead_s = 1;
  std::vector<NavState> poses = MakeFlightPoses(FlightKind::kHover, route, flight);
  const SplineTrajectory hovering = SplineTrajectory::Fit(poses, kSpline);
  std::optional<SE3> rest;
  for (NavState& pose : poses) {
    const double since_s = ToSeconds(pose.t - flight.start) - kSetDown_s;
    if (since_s < 0) continue;
    if (!rest) rest = pose.T_WB;
    const double share = std::exp(-std::pow(since_s / kSettling_s, 2));
    pose.T_WB.p = rest->p + share * (pose.T_WB.p - rest->p);
    pose.T_WB.q = rest->q.slerp(share, pose.T_WB.q);
  }
  return {{"hover", hovering, 0.5, duration_s, {}},
          {"rest", SplineTrajectory::Fit(poses, kSpline), 0.5, duration_s, {}}};
}

std::vector<Scenario> FindScenarios(double duration_s) {
  if (const auto folder = testing::DataDir("euroc_flights")) {
    return RecordedScenarios(*folder, duration_s);
  }
  std::fprintf(stderr, "%s\n", testing::MissingData("euroc_flights").c_str());
  return MadeUpScenarios(duration_s);
}

SimulatedRun Simulate(const Scenario& scenario,
                      const ConsistencyOptions& options,
                      std::uint64_t seed) {
  FeatureSimulatorOptions simulator = options.simulator;
  simulator.start_s = scenario.start_s;
  simulator.duration_s = scenario.duration_s;
  simulator.corridor = scenario.corridor;
  return SimulateFeatures(scenario.trajectory, EurocRig(), simulator, seed);
}

}  // namespace facet
