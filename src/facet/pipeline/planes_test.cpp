// SPDX-License-Identifier: BSD-2-Clause
// Planes in the whole back half, search and estimator together, on simulated features.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/pipeline/simulated_front.h"

namespace facet {
namespace {

using testing::RunOnFeatures;

constexpr double kLookAway_s = 5, kLookBack_s = 13, kEnd_s = 19, kTurn_s = 2;

// From 0 to 1 between both times.
double SmoothStep(double t, double from, double to) {
  const double x = std::clamp((t - from) / (to - from), 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

// Swings about one place while it looks at a wall, at the one behind, and at the first again.
SplineTrajectory LookAround() {
  constexpr SplineOptions kSpline{0.05, 1e-6};
  Matrix3d R_WB;  // x up, z forward
  R_WB << 0, 0, 1, 0, -1, 0, 1, 0, 0;
  std::vector<NavState> poses;
  for (int i = 0; i <= 200 * (kEnd_s + 1); ++i) {
    const double t = i / 200.0;
    const double turned = SmoothStep(t, kLookAway_s, kLookAway_s + kTurn_s) -
                          SmoothStep(t, kLookBack_s, kLookBack_s + kTurn_s);
    NavState pose;
    pose.t = Timestamp{1'400'000'000'000'000'000} + FromSeconds(t);
    pose.T_WB.q = ExpSO3({0, 0, turned * std::numbers::pi}) * Quaterniond(R_WB);
    pose.T_WB.p = {0.3 * std::sin(1.9 * t), 0.5 * std::sin(1.4 * t), 1.3 + 0.3 * std::sin(2.3 * t)};
    poses.push_back(pose);
  }
  return SplineTrajectory::Fit(poses, kSpline);
}

SimulatedRun Simulate(double roughness_m, double duration_s = kEnd_s) {
  FeatureSimulatorOptions options;
  options.max_tracks = 150;  // so that the wall is persistent before it leaves the view
  options.duration_s = duration_s;
  options.roughness_m = roughness_m;
  options.room.num_boxes = options.room.num_boards = 0;
  return SimulateFeatures(LookAround(), EurocRig(), options, 1);
}

std::set<LandmarkId> MembersOf(PlaneId plane, const MapSnapshot& map) {
  std::set<LandmarkId> out;
  for (const LandmarkEstimate& landmark : map.landmarks) {
    if (landmark.IsOn(plane)) out.insert(landmark.id);
  }
  return out;
}

// The plane with most landmarks across the line of sight.
PlaneId PlaneInFront(const MapSnapshot& map) {
  const Vector3d forward_W = map.latest.T_WB.q * Vector3d::UnitZ();
  PlaneId best;
  std::size_t most = 0;
  for (const PlaneEstimate& plane : map.planes) {
    const std::size_t num = MembersOf(plane.id, map).size();
    if (std::abs(plane.plane_W.n.dot(forward_W)) < 0.9 || num <= most) continue;
    most = num;
    best = plane.id;
  }
  return best;
}

TEST(PlanesTest, APlaneOutOfViewSleepsInTheEstimatorAndIsRecognised) {
  const SimulatedRun run = Simulate(0);
  PlaneId wall;
  std::set<LandmarkId> before, after;
  std::size_t num_asleep = 0;
  RunOnFeatures(run, VioOptions(), [&](const VioOutput& output) {
    if (!output.snapshot) return;
    const MapSnapshot& map = *output.snapshot;
    const double t = ToSeconds(output.t - run.frames[0].t);
    if (t < kLookAway_s) {
      wall = PlaneInFront(map);
      before = MembersOf(wall, map);
      return;
    }
    EXPECT_EQ(std::count_if(map.planes.begin(),
                            map.planes.end(),
                            [&](const PlaneEstimate& plane) { return plane.id == wall; }),
              1)
        << t;
    if (t < kLookBack_s) {
      num_asleep += MembersOf(wall, map).empty() ? 1 : 0;
      return;
    }
    after = MembersOf(wall, map);
    if (t > kLookBack_s + kTurn_s + 1) {
      EXPECT_EQ(PlaneInFront(map), wall) << t;
    }
    for (const LandmarkEstimate& landmark : map.landmarks)
      EXPECT_FALSE(before.contains(landmark.id)) << t;
  });
  ASSERT_TRUE(wall.IsValid());
  EXPECT_GT(before.size(), 20u);
  EXPECT_GT(num_asleep, 5u);
  EXPECT_GT(after.size(), 20u);
}

std::vector<NavState> States(const SimulatedRun& run,
                             Formulation pipeline,
                             int* most_planes = nullptr) {
  VioOptions options;
  options.pipeline = pipeline;
  std::vector<NavState> out;
  RunOnFeatures(run, options, [&](const VioOutput& output) {
    if (output.has_pose) out.push_back(output.state);
    if (most_planes != nullptr) *most_planes = std::max(*most_planes, output.num_planes);
  });
  return out;
}

bool SameBits(const std::vector<NavState>& a, const std::vector<NavState>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.t == y.t && x.T_WB.p == y.T_WB.p && x.T_WB.q.coeffs() == y.T_WB.q.coeffs() &&
           x.v_WB == y.v_WB;
  });
}

TEST(PlanesTest, ThePipelinesDifferWherePlanesAreSeen) {
  const SimulatedRun run = Simulate(0, 5);
  int num_planes = 0;
  const auto s = States(run, Formulation::kS), sp = States(run, Formulation::kSP),
             spr = States(run, Formulation::kSPR, &num_planes);
  EXPECT_GT(num_planes, 0);
  EXPECT_FALSE(SameBits(s, sp));
  EXPECT_FALSE(SameBits(s, spr));
  EXPECT_FALSE(SameBits(sp, spr));
}

TEST(PlanesTest, ThePipelinesAreTheSameWhereNoPlaneIsFound) {
  const SimulatedRun run = Simulate(0.3, 5);  // nothing is flat
  int num_planes = 0;
  const auto s = States(run, Formulation::kS), sp = States(run, Formulation::kSP),
             spr = States(run, Formulation::kSPR, &num_planes);
  EXPECT_EQ(num_planes, 0);
  EXPECT_GT(s.size(), 80u);
  EXPECT_TRUE(SameBits(s, sp));
  EXPECT_TRUE(SameBits(s, spr));
}

}  // namespace
}  // namespace facet
