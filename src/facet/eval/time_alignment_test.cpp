// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/time_alignment.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

SE3 PoseAt(double t) {
  return {ExpSO3({0.1 * std::sin(t), 0, 0.4 * t}),
          {3 * std::cos(0.5 * t), 2 * std::sin(0.7 * t), 0.5 * std::sin(t)}};
}

std::vector<StampedPose> Poses(double rate_hz, double seconds, double clock_error_s, double noise) {
  Rng rng(5);
  std::vector<StampedPose> poses;
  for (int i = 0; i < rate_hz * seconds; ++i) {
    const double t = i / rate_hz;
    poses.push_back({Timestamp{FromSeconds(100 + t).ns},
                     PoseAt(t + clock_error_s).Retract(Vector3d::Zero(), noise * rng.Normal3())});
  }
  return poses;
}

TEST(TimeAlignmentTest, FindsTheOffsetOfTheClocks) {
  const auto truth = Poses(200, 30, 0, 0);
  for (double offset_s : {0.0, 0.0237, -0.31}) {
    const auto estimate = Poses(20, 29, offset_s, 0);
    const Duration found = EstimateTimeOffset(estimate, truth, AlignmentKind::kSE3);
    EXPECT_NEAR(ToSeconds(found), offset_s, 1e-4);
  }
}

TEST(TimeAlignmentTest, NoiseMovesItLittle) {
  const Duration found =
      EstimateTimeOffset(Poses(20, 29, 0.05, 0.02), Poses(200, 30, 0, 0), AlignmentKind::kSE3);
  EXPECT_NEAR(ToSeconds(found), 0.05, 3e-3);
}

TEST(TimeAlignmentTest, ZeroWithoutOverlap) {
  const auto truth = ShiftInTime(Poses(200, 5, 0, 0), {1'000'000'000'000});
  EXPECT_EQ(EstimateTimeOffset(Poses(20, 5, 0, 0), truth, AlignmentKind::kSE3).ns, 0);
}

}  // namespace
}  // namespace facet
