// SPDX-License-Identifier: BSD-2-Clause
// The back end on real corners: no reset, a small trajectory error and the board's true shape.
#include "april_corners_study.h"
#include <gtest/gtest.h>

#include "facet/testing/data_dir.h"

namespace facet {
namespace {

TEST(AprilCornersTest, FollowsTheBoard) {
  const auto folder = testing::DataDir("euroc_april_corners");
  if (!folder) GTEST_SKIP() << testing::MissingData("euroc_april_corners");
  const auto mav0 = testing::DataDir("euroc_mh01_handheld/mav0");
  if (!mav0) GTEST_SKIP() << testing::MissingData("euroc_mh01_handheld");

  const AprilRecording recording = LoadAprilRecording(*folder, *mav0);
  ASSERT_EQ(recording.corners_G.size(), 144u);
  const AprilRun run = RunAprilCorners(recording, {});
  const AprilFigures figures = EvaluateAprilCorners(recording, run);

  // The recording has a stretch of 1.2 s without any corner; that is no reason to start again.
  EXPECT_EQ(run.num_resets, 0);
  EXPECT_GT(figures.coverage, 0.98);
  EXPECT_LE(figures.trajectory.ate_m.rmse, 0.03) << "m";
  EXPECT_LE(figures.trajectory.ate_m.median, 0.015) << "m";
  ASSERT_TRUE(figures.trajectory.scale_error_percent);
  EXPECT_LE(std::abs(*figures.trajectory.scale_error_percent), 0.5) << "%";
  EXPECT_LE(figures.rotation_deg.median, 0.5) << "deg";
  EXPECT_GT(run.fits.size(), 300u);
  EXPECT_LE(figures.landmark_rms_m, 0.004) << "m";
  EXPECT_LE(figures.flatness_m, 0.004) << "m";
}

}  // namespace
}  // namespace facet
