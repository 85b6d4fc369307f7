// SPDX-License-Identifier: BSD-2-Clause
// Configurations that users saved with an earlier version are still read, or refused with a reason.
#include "load_options.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/config_file.h"
#include "facet/io/errors.h"
#include "facet/pipeline/vio_pipeline.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/folders.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

std::string SavedConfig() {
  return testing::SourceFolder() / "testdata" / "saved_config_0.1.yaml";
}

std::string MessageOf(const std::string& override) {
  try {
    LoadOptions("", {override});
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST(LoadOptionsTest, UnknownInstructionSetsAreRefusedWithTheOnesThatThereAre) {
  EXPECT_THAT(
      MessageOf("frontend.klt.simd=avx512"),
      HasSubstr("'avx512' is not one of these, allowed: auto | avx2 | sse2 | neon | scalar"));
  EXPECT_EQ(MessageOf("frontend.klt.simd=auto"), "no error");
}

std::vector<std::string> ExtremesOf(const ConfigField& field) {
  std::vector<std::string> values = field.choices;
  if (std::holds_alternative<bool*>(field.value)) values = {"true", "false"};
  const bool is_int = std::holds_alternative<int*>(field.value);
  if (!is_int && !std::holds_alternative<double*>(field.value)) return values;
  for (const double end : {field.range.min, field.range.max}) {
    if (std::isfinite(end))
      values.push_back(is_int ? std::to_string(std::lround(end)) : std::to_string(end));
  }
  return values;
}

// What is within its range is refused nowhere further in, where the message would be of no use.
TEST(LoadOptionsTest, EveryAllowedValueIsTakenByThePipeline) {
  VioOptions listed;
  const cv::Mat black(480, 752, CV_8UC1, 0.0);
  int num_tried = 0;
  for (const ConfigField& field : ListFields(listed)) {
    for (const std::string& value : ExtremesOf(field)) {
      const std::string override = field.key + "=" + value;
      try {
        VioPipeline vio(EurocRig(), ImuNoise(), LoadOptions("", {override}).options);
        vio.AddStereo({Timestamp{1}, black, black});
        ++num_tried;
      } catch (const ConfigError& error) {
        EXPECT_THAT(error.what(), HasSubstr("allowed")) << override;
      } catch (const std::exception& error) {
        ADD_FAILURE() << override << ": " << error.what();
      }
    }
  }
  EXPECT_GT(num_tried, 100);
}

TEST(LoadOptionsTest, SavedDefaultsOfAnEarlierVersionAreTodaysDefaults) {
  // But for those whose value has changed since.
  const LoadedOptions loaded = LoadOptions(
      SavedConfig(),
      {"estimator.imu.gyro_noise_scale=6", "estimator.planes.relations.gravity_sigma_deg=0.3"});
  EXPECT_EQ(FormatOptions(loaded.options, Audience::kExperts),
            FormatOptions(VioOptions(), Audience::kExperts));
  EXPECT_FALSE(loaded.notices.empty());
}

TEST(LoadOptionsTest, ThereIsOneNoticeForEachRetiredOption) {
  for (const RetiredOption& option : RetiredOptions()) {
    const std::string override = std::string(option.key) + "=" + option.default_text;
    EXPECT_EQ(LoadOptions("", {override}).notices.size(), 1u) << override;
  }
  // But for the two that later versions had.
  EXPECT_EQ(LoadOptions(SavedConfig(), {}).notices.size(), RetiredOptions().size() - 2);
}

TEST(LoadOptionsTest, NoRetiredOptionIsStillAnOptionAndAllSuccessorsAre) {
  VioOptions options;
  const auto fields = ListFields(options);
  const auto is_option = [&](const std::string& key) {
    return std::any_of(
        fields.begin(), fields.end(), [&](const ConfigField& field) { return field.key == key; });
  };
  for (const RetiredOption& option : RetiredOptions()) {
    EXPECT_FALSE(is_option(option.key)) << option.key;
    EXPECT_TRUE(std::string(option.new_key).empty() || is_option(option.new_key)) << option.new_key;
  }
}

TEST(LoadOptionsTest, RetiredOptionWithAnotherValueIsRefusedWithTheValueThatHolds) {
  for (const RetiredOption& option : RetiredOptions()) {
    if (option.new_key[0] != 0) continue;
    const std::string now = option.now;
    EXPECT_THAT(MessageOf(std::string(option.key) + "=0.123"),
                HasSubstr("is now " +
                          (now.empty() ? "fixed at " + std::string(option.default_text) : now)));
  }
}

TEST(LoadOptionsTest, RenamedOptionSetsItsSuccessor) {
  const LoadedOptions loaded = LoadOptions("", {"mesh.support.enabled=false"});
  EXPECT_FALSE(loaded.options.frontend.support.enabled);
  EXPECT_EQ(loaded.notices,
            std::vector<std::string>{
                "--set: mesh.support.enabled is now called frontend.support.enabled"});
}

// What most users ever turn; the others are for experts.
TEST(LoadOptionsTest, UsersSeeAFewOptions) {
  VioOptions options;
  const auto fields = ListFields(options);
  const auto num_for_users = std::count_if(fields.begin(), fields.end(), [](const auto& field) {
    return field.audience == Audience::kUsers;
  });
  EXPECT_GE(num_for_users, 10);
  EXPECT_LE(num_for_users, 20);
}

}  // namespace
}  // namespace facet
