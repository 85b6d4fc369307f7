// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/truth_path.h"

#include <cmath>

#include <gtest/gtest.h>

namespace facet {
namespace {

constexpr std::int64_t kPeriod_ns = 50'000'000;

struct Frame {
  Timestamp t;
  bool has_pose = false;
  SE3 T_WB;
};

/// Frames along a circle of radius 2 m in W, without a pose up to the third.
std::vector<Frame> Circle(int num, double radius_m) {
  std::vector<Frame> frames;
  for (int i = 0; i < num; ++i) {
    Frame& frame = frames.emplace_back();
    frame.t = {i * kPeriod_ns};
    frame.has_pose = i > 2;
    frame.T_WB.p = {radius_m * std::cos(0.05 * i), radius_m * std::sin(0.05 * i), 0};
  }
  return frames;
}

SE3 AnyPlace() {
  return {Quaterniond(Eigen::AngleAxisd(0.7, Vector3d::UnitZ())), {3, -2, 1}};
}

/// The same path in G, ten poses to a frame.
std::vector<StampedPose> TruthOf(const std::vector<Frame>& frames, const SE3& T_GW) {
  std::vector<StampedPose> truth;
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    for (int k = 0; k < 10; ++k) {
      const Vector3d a = frames[i].T_WB.p, b = frames[i + 1].T_WB.p;
      truth.push_back({{frames[i].t.ns + k * kPeriod_ns / 10}, T_GW});
      truth.back().T_WB.p = T_GW * Vector3d(a + 0.1 * k * (b - a));
    }
  }
  truth.push_back({frames.back().t, T_GW});
  truth.back().T_WB.p = T_GW * frames.back().T_WB.p;
  return truth;
}

std::optional<TruthPath> PathOf(const std::vector<Frame>& frames,
                                const std::vector<StampedPose>& truth) {
  std::vector<StampedPose> estimate;
  std::vector<Timestamp> stamps;
  for (const Frame& frame : frames) {
    stamps.push_back(frame.t);
    if (frame.has_pose) estimate.push_back({frame.t, frame.T_WB});
  }
  return FindTruthPath(estimate, stamps, truth);
}

TEST(TruthPath, LiesOnAnEstimateWithoutErrors) {
  const auto frames = Circle(100, 2);
  const auto path = PathOf(frames, TruthOf(frames, AnyPlace()));
  ASSERT_TRUE(path);
  EXPECT_LT((path->T_GW.p - AnyPlace().p).norm(), 1e-9);
  ASSERT_EQ(path->poses_W.size(), 97u);  // from the first pose on
  for (std::size_t i = 0; i < path->poses_W.size(); ++i) {
    EXPECT_EQ(path->poses_W[i].t, frames[i + 3].t);
    EXPECT_LT((path->poses_W[i].T_WB.p - frames[i + 3].T_WB.p).norm(), 1e-9);
  }
}

TEST(TruthPath, AnErrorStaysAndHolesHaveNone) {
  auto frames = Circle(100, 2);
  auto truth = TruthOf(frames, AnyPlace());
  frames[50].T_WB.p.z() += 0.2;
  frames[60].has_pose = false;
  std::erase_if(truth, [&](const StampedPose& pose) {
    return pose.t > frames[70].t && pose.t < frames[80].t;
  });
  const auto path = PathOf(frames, truth);
  ASSERT_TRUE(path);
  EXPECT_EQ(path->poses_W.size(), 97u - 9u);  // one of them where the run had no pose
  EXPECT_EQ(path->poses_W[57].t, frames[60].t);
  const double error = (path->poses_W[47].T_WB.p - frames[50].T_WB.p).norm();
  EXPECT_NEAR(error, 0.2, 0.01);
}

TEST(TruthPath, WhatHardlyMovesIsPlacedByItsFirstPose) {
  auto frames = Circle(10, 0.01);
  const auto path = PathOf(frames, TruthOf(frames, AnyPlace()));
  ASSERT_TRUE(path);
  EXPECT_LT((path->T_GW.p - AnyPlace().p).norm(), 1e-9);
  EXPECT_LT(path->T_GW.q.angularDistance(AnyPlace().q), 1e-9);
}

TEST(TruthPath, AnotherTimeHasNoTruth) {
  const auto frames = Circle(20, 2);
  auto truth = TruthOf(frames, AnyPlace());
  for (StampedPose& pose : truth)
    pose.t.ns += 1'000'000'000'000;
  EXPECT_FALSE(PathOf(frames, truth));
  EXPECT_FALSE(PathOf({}, truth));
  EXPECT_FALSE(PathOf(frames, {}));
}

}  // namespace
}  // namespace facet
