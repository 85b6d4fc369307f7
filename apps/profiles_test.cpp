// SPDX-License-Identifier: BSD-2-Clause
// The ready configurations for sensors that people have.
#include <fstream>
#include <string>

#include "load_options.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/config_file.h"
#include "facet/pipeline/vio_pipeline.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/folders.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

class ProfilesTest : public ::testing::TestWithParam<const char*> {
 protected:
  std::string File() const {
    return testing::SourceFolder() / "config" / (std::string(GetParam()) + ".yaml");
  }
};

TEST_P(ProfilesTest, LoadsAndRuns) {
  const LoadedOptions loaded = LoadOptions(File(), {});
  EXPECT_THAT(loaded.notices, ::testing::IsEmpty());
  const StereoRig rig = EurocRig();
  VioPipeline vio(rig, ImuNoise(), loaded.options);
  const cv::Mat grey(rig.cameras[0].height(), rig.cameras[0].width(), CV_8UC1, 99.0);
  vio.AddImu({Timestamp{1}, Vector3d::Zero(), {0, 0, loaded.options.estimator.imu.gravity_mps2}});
  EXPECT_FALSE(vio.AddStereo({Timestamp{1}, grey, grey}).has_pose);
}

// Nothing is listed that is a default, and every value says where it comes from.
TEST_P(ProfilesTest, ListsWhatDiffersWithItsSource) {
  VioOptions defaults, options = LoadOptions(File(), {}).options;
  const auto before = ListFields(defaults), after = ListFields(options);
  ASSERT_EQ(before.size(), after.size());
  int num_changed = 0, num_listed = 0;
  for (std::size_t i = 0; i < before.size(); ++i)
    num_changed += FormatValue(before[i]) == FormatValue(after[i]) ? 0 : 1;

  std::ifstream file(File());
  std::string line, head;
  while (std::getline(file, line)) {
    EXPECT_LE(line.size(), 120u) << line;
    const std::size_t value = line.find(": ");
    if (line.starts_with('#')) {
      head += line;
    } else if (value != std::string::npos) {
      ++num_listed;
      EXPECT_THAT(line.substr(value), HasSubstr("  # "));
    }
  }
  EXPECT_EQ(num_listed, num_changed);
  EXPECT_GT(num_changed, 0);
  EXPECT_THAT(head, HasSubstr("UNVERIFIED"));
}

INSTANTIATE_TEST_SUITE_P(
    All,
    ProfilesTest,
    ::testing::Values("realsense_d435i", "realsense_d455", "zed2", "oak_d", "tum_vi", "uzh_fpv"),
    [](const auto& profile) { return std::string(profile.param); });

}  // namespace
}  // namespace facet
