// SPDX-License-Identifier: BSD-2-Clause
// The real recordings: every file opens without a warning and the WebP and JPEG paths decode.
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/asl_dataset.h"
#include "facet/io/trajectory_file.h"
#include "facet/testing/folders.h"

namespace facet {
namespace {

std::filesystem::path DataFolder() {
  const char* folder = std::getenv("FACET_DATA_DIR");
  return folder != nullptr ? folder : testing::SourceFolder().parent_path() / "shared" / "data";
}

struct Recording {
  const char* name;
  std::size_t num_frames;
};

class AslRecordingsTest : public ::testing::TestWithParam<Recording> {};

TEST_P(AslRecordingsTest, OpensAndDecodes) {
  const std::filesystem::path sequence = DataFolder() / GetParam().name;
  if (!std::filesystem::exists(sequence)) GTEST_SKIP() << sequence << " is not there";
  AslDataset dataset(sequence);
  EXPECT_THAT(dataset.warnings(), ::testing::IsEmpty());
  EXPECT_EQ(dataset.frames().size(), GetParam().num_frames);
  EXPECT_NEAR(dataset.rig().baseline_m(), 0.11, 0.001);
  cv::Mat left, right;
  for (std::size_t i = 0; i < dataset.frames().size(); i += 40) {
    EXPECT_EQ(dataset.ReadPair(i, left, right), "");
    EXPECT_EQ(right.cols, 752);
    EXPECT_GT(cv::mean(left)[0], 10);
  }
  EXPECT_GT(ReadTrajectory(FindTruth(sequence)).poses.size(), 1000u);
}

INSTANTIATE_TEST_SUITE_P(All,
                         AslRecordingsTest,
                         ::testing::Values(Recording{"euroc_mh01_handheld", 320},
                                           Recording{"rendered_room", 481}),
                         [](const auto& recording) { return recording.param.name; });

TEST(PublishedEstimatesTest, AreRead) {
  const std::filesystem::path folder = DataFolder() / "published_estimates";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const Trajectory orbslam = ReadTrajectory(folder / "orbslam_V1_02.tum");
  EXPECT_EQ(orbslam.poses[0].t.ns, 1403715529112143517);
  EXPECT_EQ(orbslam.poses[0].T_WB.p.x(), -6.151e-2);
  EXPECT_GE(ReadTrajectory(folder / "vislam_rp_V1_02_run0.tum").poses.size(), 1355u);
}

}  // namespace
}  // namespace facet
