// SPDX-License-Identifier: BSD-2-Clause
// A flight with a stereo pair of fisheyes that see 190 deg: what lies beside the cameras and behind
// them counts like everything else.
#include <gtest/gtest.h>

#include "facet/estimator/vio_estimator.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/estimator/spoilt_run.h"

namespace facet {
namespace {

StereoRig FisheyeRig() {
  const CameraIntrinsics k{512,
                           512,
                           150,
                           150,
                           255,
                           257,
                           DistortionModel::kEquidistant,
                           {0.0034, 0.0007, -0.002, 0.0002}};
  StereoRig rig = EurocRig();
  rig.cameras.fill(CameraModel(k));
  return rig;
}

SimulatedRun Fly(const StereoRig& rig) {
  FeatureSimulatorOptions options;
  options.max_tracks = 120;
  options.duration_s = 8;
  return SimulateFeatures(SplineTrajectory::Fit(MakeFlight(10, 2)), rig, options, 1);
}

double CosineFromAxis(const StereoRig& rig, const FeatureObservation& feature) {
  // Noise may move a pixel beyond the last ray.
  return rig.cameras[0].Unproject(feature.px_left).value_or(-Vector3d::UnitZ()).z();
}

struct Flight {
  double error_m = 0;  // of the motion over the last six seconds
  TrackingStatus status = TrackingStatus::kLost;
};

// `max_cosine`: features nearer to the axis are left out once the estimator has started.
Flight Estimate(const SimulatedRun& run, double max_cosine) {
  const ImuBuffer imu = testing::ImuOf(run);
  VioEstimator estimator(run.rig, ImuNoise{}, EstimatorOptions{});
  StageTimes times;
  std::vector<EstimatorResult> results;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    testing::EstimatorInput input = testing::InputOf(run, imu, i);
    if (!results.empty() && results.back().has_state) {
      std::erase_if(input.observations.features, [&](const FeatureObservation& f) {
        return CosineFromAxis(run.rig, f) > max_cosine;
      });
    }
    results.push_back(estimator.AddFrame(input.observations, input.imu, times));
  }
  const std::size_t first = 40, last = results.size() - 1;
  const SE3 estimated = results[first].state.T_WB.Inverse() * results[last].state.T_WB;
  const SE3 truth = run.truth[first].T_WB.Inverse() * run.truth[last].T_WB;
  return {(estimated.p - truth.p).norm(), results[last].status};
}

TEST(WideLensFlightTest, WhatIsBesideTheCamerasCounts) {
  const SimulatedRun run = Fly(FisheyeRig());
  std::size_t num_behind = 0, num = 0;
  for (const FrameObservations& frame : run.frames) {
    for (const FeatureObservation& feature : frame.features) {
      num_behind += CosineFromAxis(run.rig, feature) < 0 ? 1 : 0;
      ++num;
    }
  }
  EXPECT_GT(num_behind, num / 50) << "of " << num;
  const Flight flight = Estimate(run, 1);
  EXPECT_EQ(flight.status, TrackingStatus::kOk);
  EXPECT_LT(flight.error_m, 0.03);
}

// Without anything within 70 deg of the axis.
TEST(WideLensFlightTest, WhatIsBesideTheCamerasIsEnough) {
  const Flight flight = Estimate(Fly(FisheyeRig()), 0.34);
  EXPECT_EQ(flight.status, TrackingStatus::kOk);
  EXPECT_LT(flight.error_m, 0.05);
}

}  // namespace
}  // namespace facet
