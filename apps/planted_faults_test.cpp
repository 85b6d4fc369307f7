// SPDX-License-Identifier: BSD-2-Clause
// Faults of sensors and calibrations, planted in a recording and run as a user runs it: how large
// the error becomes, whether the sigmas cover it, and what is told. scripts/fault_table.py has all
// faults and more starts.
#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "facet/io/json_file.h"
#include "facet/testing/data_dir.h"
#include "facet/testing/io/program_run.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using ::testing::HasSubstr;

struct Outcome {
  int exit_code = -1;
  std::string told;
  ordered_json evaluation, summary;

  double ate_m() const {
    double most = evaluation.at("ate").at("rmse_m");
    if (!evaluation.contains("segments")) return most;
    most = 0;
    for (const auto& segment : evaluation.at("segments"))
      most = std::max(most, segment.at("ate").at("rmse_m").get<double>());
    return most;
  }
  double position_nees() const { return evaluation.at("consistency").at("position").at("nees"); }
};

Outcome RunAndEvaluate(const fs::path& sequence, const fs::path& folder) {
  const fs::path out = folder / "out";
  const ProgramRun run = RunFacet("run " + sequence.string() + " --out " + out.string() +
                                  " --quiet --set mesh.map.enabled=false");
  Outcome outcome{run.exit_code, run.err, {}, {}};
  if (run.exit_code != 0) return outcome;
  const ProgramRun evaluated = RunFacet("evaluate " + out.string() + " --truth " +
                                        sequence.string() + " --parts trajectory,consistency");
  EXPECT_EQ(evaluated.exit_code, 0) << evaluated.err;
  outcome.evaluation = ReadJsonObject(out / "evaluation.json");
  outcome.summary = ReadJsonObject(out / "summary.json");
  return outcome;
}

class PlantedFaultsTest : public ::testing::Test {
 protected:
  static constexpr const char* kRecording = "rendered_room";

  void SetUp() override {
    recording_ = testing::DataDir(kRecording);
    if (!recording_) GTEST_SKIP() << testing::MissingData(kRecording);
  }

  Outcome Plant(const std::string& fault) const {
    const fs::path copy = folder_ / "copy";
    fs::remove_all(copy);
    const ProgramRun planted = RunFacet("simulate --of " + recording_->string() + " --out " +
                                        copy.string() + " --quiet --fault " + fault);
    EXPECT_EQ(planted.exit_code, 0) << planted.err;
    return RunAndEvaluate(copy, folder_.path());
  }

  std::optional<fs::path> recording_;
  TempFolder folder_;
};

TEST_F(PlantedFaultsTest, FaultsOfSensorsCostLittleAndAreCovered) {
  struct Case {
    const char* fault;
    double most_over_clean;
    const char* told;  // a part of it
  };
  const double clean_m = RunAndEvaluate(*recording_, folder_.path()).ate_m();
  EXPECT_LT(clean_m, 0.002);
  const Case cases[] = {{"imu_glitch:gyro=35", 2, "IMU"},
                        {"imu_gap:length=0.3", 2, "IMU"},
                        {"frozen:length=0.5", 2, "images repeat"},
                        {"object:share=0.3", 3, ""},
                        {"no_camera:length=3,camera=1", 2, "right"},
                        {"black:length=1", 2, "black"}};
  for (const Case& c : cases) {
    const Outcome outcome = Plant(c.fault);
    ASSERT_EQ(outcome.exit_code, 0) << c.fault << ": " << outcome.told;
    EXPECT_LE(outcome.ate_m(), c.most_over_clean * clean_m) << c.fault;
    EXPECT_LE(outcome.position_nees(), 3) << c.fault;
    EXPECT_THAT(outcome.told, HasSubstr(c.told)) << c.fault;
  }
}

// Where dead reckoning cannot bridge it, a segment begins, each aligned for itself by `evaluate`.
TEST_F(PlantedFaultsTest, APauseOfAllSensorsBeginsASegmentThatIsCovered) {
  const Outcome outcome = Plant("pause:length=3");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.told;
  ASSERT_EQ(outcome.summary.at("segments").size(), 2u);
  ASSERT_EQ(outcome.evaluation.at("segments").size(), 2u);
  EXPECT_LT(outcome.summary.at("segments")[0].at("last_ns").get<std::int64_t>(),
            outcome.summary.at("segments")[1].at("first_ns").get<std::int64_t>());
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(outcome.summary.at("segments")[k].at("segment"), k);
    EXPECT_EQ(outcome.evaluation.at("segments")[k].at("segment"), k);
    EXPECT_EQ(outcome.evaluation.at("segments")[k].at("poses_with_truth"),
              outcome.summary.at("segments")[k].at("frames_with_pose"));
  }
  EXPECT_LE(outcome.ate_m(), 0.002);
  EXPECT_LE(outcome.position_nees(), 3);
  EXPECT_THAT(outcome.told, HasSubstr("a new segment begins there"));
}

TEST_F(PlantedFaultsTest, WrongCalibrationsAreNamedAndCovered) {
  const Outcome focal = Plant("focal:percent=1");
  ASSERT_EQ(focal.exit_code, 0);
  EXPECT_LE(focal.position_nees(), 3);
  EXPECT_THAT(focal.told, HasSubstr("focal length"));
  const Outcome baseline = Plant("baseline:percent=2");
  ASSERT_EQ(baseline.exit_code, 0);
  EXPECT_LE(baseline.position_nees(), 3.5);  // one start; 2.7 in the median of three
  EXPECT_THAT(baseline.told, HasSubstr("too large for the accelerometer"));
  const Outcome doubled = Plant("baseline:percent=100");
  EXPECT_EQ(doubled.exit_code, 3);
  EXPECT_THAT(doubled.told, HasSubstr("the calibration cannot be right"));
}

}  // namespace
}  // namespace facet
