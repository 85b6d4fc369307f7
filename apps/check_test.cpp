// SPDX-License-Identifier: BSD-2-Clause
// `facet check`: what it prints and writes, how it ends, and that good recordings have no finding.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/testing/data_dir.h"
#include "facet/testing/io/program_run.h"
#include "facet/testing/recording/test_bags.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class CheckTest : public ::testing::Test {
 protected:
  CheckTest() { WriteTestSequence(Sequence()); }
  std::filesystem::path Sequence() const { return folder_ / "seq"; }
  std::string Json() const { return (folder_ / "report.json").string(); }
  TempFolder folder_;
};

TEST_F(CheckTest, NamesWhatIsWrongAndEndsWithExitCode3) {
  const ProgramRun run = RunFacet("check " + Sequence().string() + " --json " + Json());
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("12 frames in 0.55 s, 12 looked at"),
                    HasSubstr("too_short (certain): the images last for 0."),
                    HasSubstr("What to do: record longer"),
                    HasSubstr("not checked: time_offset (too few turns"),
                    Not(HasSubstr("nothing wrong"))));
  EXPECT_THAT(run.err, HasSubstr("wrong; what to do stands in the report"));
  EXPECT_EQ(Lines(run.err).size(), 1u);
  EXPECT_THAT(ReadText(Json()),
              AllOf(HasSubstr("\"name\": \"too_short\""), HasSubstr("\"sureness\": \"certain\"")));
}

TEST_F(CheckTest, ABagWithoutCalibrationIsCheckedAsFarAsItGoes) {
  const std::string bag = (folder_ / "a.mcap").string();
  WriteText(bag, McapBytes(MessagesOfSequence(Sequence(), MessageEncoding::kCdr)));
  const ProgramRun run = RunFacet("check " + bag);
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.out, AllOf(HasSubstr("no_calibration"), HasSubstr("12 looked at")));
}

TEST_F(CheckTest, StampsThatRunBackwardsAreCountedByTheReader) {
  EditLines(Sequence() / "mav0" / "imu0" / "data.csv", [](std::vector<std::string>& lines) {
    std::swap(lines[20], lines[21]);
    std::swap(lines[40], lines[41]);
  });
  EXPECT_THAT(RunFacet("check " + Sequence().string()).out,
              HasSubstr("stamps_backward (certain): stamps of 2 IMU samples run backwards"));
}

TEST_F(CheckTest, WhatCannotBeOpenedIsAnError) {
  const ProgramRun run = RunFacet("check " + (folder_ / "nothing").string());
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("no such folder or file"));
}

TEST(CheckRecordedTest, GoodRecordingsHaveNoFinding) {
  for (const char* name : {"euroc_mh01_handheld", "rendered_room"}) {
    const auto recording = testing::DataDir(name);
    if (!recording) GTEST_SKIP() << testing::MissingData(name);
    const ProgramRun run = RunFacet("check " + recording->string());
    EXPECT_EQ(run.exit_code, 0) << run.out;
    EXPECT_THAT(run.out, HasSubstr("nothing wrong was found"));
  }
}

#ifdef FACET_HAS_SIMULATOR
TEST(CheckRecordedTest, PlantedDefectsAreNamed) {
  const auto recording = testing::DataDir("euroc_mh01_handheld");
  if (!recording) GTEST_SKIP() << testing::MissingData("euroc_mh01_handheld");
  const std::pair<const char*, const char*> defects[] = {
      {"imu_early:ms=10", "time_offset (certain)"},
      {"cameras_turned:axis=1,deg=3", "camera_imu_rotation ("},
      {"imu_degrees", "the gyroscope measured in deg/s"},
      {"swapped", "cameras_swapped (certain)"},
      {"right_turned:axis=0,deg=0.2", "right_turned (certain)"},
      {"imu_gap:length=0.1", "imu_gap (certain)"},
  };
  for (const auto& [fault, words] : defects) {
    const TempFolder folder;
    const std::string out = (folder / "damaged").string();
    ASSERT_EQ(RunFacet("simulate --quiet --of " + recording->string() +
                       " --fault cut:length=10 --fault " + fault + " --out " + out)
                  .exit_code,
              0);
    const ProgramRun run = RunFacet("check " + out);
    EXPECT_EQ(run.exit_code, 3) << fault;
    EXPECT_THAT(run.out, HasSubstr(words)) << fault;
  }
}
#endif

}  // namespace
}  // namespace facet
