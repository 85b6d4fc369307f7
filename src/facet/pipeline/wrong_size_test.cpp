// SPDX-License-Identifier: BSD-2-Clause
// What the states of the whole back half claim to know with a baseline that is wrong, on simulated
// features.
#include <cmath>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/pipeline/simulated_front.h"

namespace facet {
namespace {

constexpr double kDuration_s = 25;

// Position and heading of the first pose are those of the world; it may not be level.
SE3 AlignLevel(const SE3& estimate, const SE3& truth) {
  const double yaw = LogSO3(estimate.q * truth.q.conjugate()).z();
  const Quaterniond q = ExpSO3(Vector3d(0, 0, yaw));
  return {q, estimate.p - q * truth.p};
}

// `baseline`: of the rig that the estimator is given, over the true one.
double PositionNees(std::uint64_t seed, double baseline, bool check_calibration) {
  FeatureSimulatorOptions simulated;
  simulated.max_tracks = 150;
  simulated.pixel_sigma = 0.1;
  simulated.duration_s = kDuration_s;
  SimulatedRun run = SimulateFeatures(
      SplineTrajectory::Fit(MakeFlight(kDuration_s, seed)), EurocRig(), simulated, seed);
  const Vector3d left = run.rig.T_BC[0].p;
  run.rig.T_BC[1].p = left + baseline * (run.rig.T_BC[1].p - left);
  VioOptions options;
  options.mesh.enabled = false;
  options.check_calibration = check_calibration;

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

TEST(WrongSizeTest, SigmasCoverABaselineThatIsWrong) {
  constexpr int kFlights = 3;
  double believed = 0, doubted = 0, right = 0;
  for (std::uint64_t seed = 1; seed <= kFlights; ++seed) {
    believed += PositionNees(seed, 1.02, false) / kFlights;
    doubted += PositionNees(seed, 1.02, true) / kFlights;
    right += PositionNees(seed, 1, true) / kFlights;
  }
  EXPECT_LT(doubted, 4) << "most of it in the seconds before anything is measured";
  EXPECT_GT(believed, 5 * doubted);
  EXPECT_LT(right, 2);
  EXPECT_GT(right, 0.2) << "not by doubting everything";
}

}  // namespace
}  // namespace facet
