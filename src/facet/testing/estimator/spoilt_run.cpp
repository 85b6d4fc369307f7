// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/estimator/spoilt_run.h"

#include <gtest/gtest.h>

#include "facet/sim/euroc_rig.h"

namespace facet::testing {

const SimulatedRun& SpoiltRun() {
  static const SimulatedRun run = [] {
    FeatureSimulatorOptions options;
    options.max_tracks = 70;
    options.duration_s = 8;
    StereoRig rig = EurocRig();
    rig.time_offset = Duration{70'000'000};
    return SimulateFeatures(SplineTrajectory::Fit(MakeFlight(10, 2)), rig, options, 1);
  }();
  return run;
}

ImuBuffer ImuOf(const SimulatedRun& run) {
  ImuBuffer buffer;
  for (const ImuSample& sample : run.imu)
    buffer.Add(sample);
  return buffer;
}

EstimatorInput InputOf(const SimulatedRun& run, const ImuBuffer& imu, std::size_t i) {
  constexpr Duration kMaxGap{20'000'000};
  EstimatorInput input{run.frames[i], {}};
  if (i > 0) input.imu = imu.Between(run.truth[i - 1].t, run.truth[i].t, kMaxGap, Duration{0});
  return input;
}

Outcome Estimate(const Spoil& spoil, const EstimatorOptions& options) {
  const SimulatedRun& run = SpoiltRun();
  const ImuBuffer imu = ImuOf(run);
  VioEstimator estimator(run.rig, ImuNoise{}, options);
  StageTimes times;
  Outcome outcome;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    EstimatorInput input = InputOf(run, imu, i);
    spoil(i, input);
    outcome.results.push_back(estimator.AddFrame(input.observations, input.imu, times));
    outcome.num_resets += outcome.results.back().was_reset;
    EXPECT_NO_THROW(estimator.Snapshot());
  }
  return outcome;
}

double MotionError(const Outcome& outcome, std::size_t from, std::size_t to) {
  const SimulatedRun& run = SpoiltRun();
  const SE3 T_est = outcome.results[from].state.T_WB.Inverse() * outcome.results[to].state.T_WB;
  const SE3 T_true = run.truth[from].T_WB.Inverse() * run.truth[to].T_WB;
  return (T_est.p - T_true.p).norm();
}

bool IsFinite(const EstimatorResult& r) {
  return r.state.T_WB.p.allFinite() && r.state.T_WB.q.coeffs().allFinite() &&
         r.state.v_WB.allFinite() && r.state.bias.b_g.allFinite() && r.state.bias.b_a.allFinite() &&
         r.covariance.allFinite();
}

void ExpectRecovers(const Outcome& outcome, double max_error) {
  const std::size_t last = outcome.results.size() - 1;
  for (const EstimatorResult& result : outcome.results) {
    EXPECT_TRUE(!result.has_state || IsFinite(result));
  }
  ASSERT_TRUE(outcome.results[last - 20].has_state && outcome.results[last].has_state);
  EXPECT_EQ(outcome.results[last].status, TrackingStatus::kOk) << outcome.results[last].reason;
  EXPECT_LT(MotionError(outcome, last - 20, last), max_error);
}

}  // namespace facet::testing
