// SPDX-License-Identifier: BSD-2-Clause
// `facet info` and `facet run` on small bags: what they print, and how they end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/testing/io/program_run.h"
#include "facet/testing/recording/test_bags.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class InfoTest : public ::testing::Test {
 protected:
  InfoTest() { WriteTestSequence(Sequence()); }
  std::filesystem::path Sequence() const { return folder_ / "seq"; }
  std::string Bag() const { return (folder_ / "a.mcap").string(); }
  std::vector<TestMessage> Messages() const {
    return MessagesOfSequence(Sequence(), MessageEncoding::kCdr);
  }
  TempFolder folder_;
};

TEST_F(InfoTest, SaysWhatIsInABag) {
  WriteText(Bag(), McapBytes(Messages()));
  const ProgramRun run = RunFacet("info " + Bag());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("kind: MCAP"),
                    HasSubstr("/cam0/image_raw "),
                    HasSubstr("duration: 0.55 s"),
                    HasSubstr("left 160 x 120, right 160 x 120 pixels"),
                    HasSubstr("20.00 Hz"),
                    HasSubstr("200.00 Hz"),
                    HasSubstr("calibration: none")));
}

TEST_F(InfoTest, SaysWhatIsInAFolder) {
  const ProgramRun run = RunFacet("info " + Sequence().string());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("ASL"), HasSubstr("20.00 Hz"), HasSubstr("baseline 0.11")));
}

TEST_F(InfoTest, GapsAreCounted) {
  std::vector<TestMessage> messages = Messages();
  const std::int64_t gap = messages.front().received.ns + 300000000;
  std::erase_if(messages, [&](const TestMessage& message) {
    return message.topic == "/imu0" && message.received.ns > gap &&
           message.received.ns <= gap + 50000000;
  });
  WriteText(Bag(), McapBytes(messages));
  EXPECT_THAT(RunFacet("info " + Bag()).out, HasSubstr("1 gaps, longest interval 0.055 s"));
}

TEST_F(InfoTest, ADamagedBagIsDescribedUpToThereAndEndsWithExitCode3) {
  const std::string bytes = McapBytes(Messages());
  WriteText(Bag(), bytes.substr(0, bytes.size() * 2 / 3));
  const ProgramRun run = RunFacet("info " + Bag());
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.out, HasSubstr("stereo pairs"));
  EXPECT_THAT(run.err, AllOf(HasSubstr("a.mcap: at byte"), HasSubstr("truncated")));

  const ProgramRun played = RunFacet("run " + Bag() + " --calibration " + Sequence().string() +
                                     " --quiet --out " + (folder_ / "out").string());
  EXPECT_EQ(played.exit_code, 3);
  EXPECT_THAT(played.err, HasSubstr("the results up to there were written"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/summary.json"));
}

TEST_F(InfoTest, AChoiceOfTopicsIsUsage) {
  std::vector<TestMessage> messages = Messages();
  for (TestMessage& message : messages) {
    if (message.topic == "/cam0/image_raw") message.topic = "/front";
    if (message.topic == "/cam1/image_raw") message.topic = "/back";
  }
  WriteText(Bag(), McapBytes(messages));
  const ProgramRun run = RunFacet("info " + Bag());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, AllOf(HasSubstr("--topics left=NAME"), HasSubstr("/front (")));
  EXPECT_EQ(RunFacet("info " + Bag() + " --topics left=/front right=/back").exit_code, 0);
}

}  // namespace
}  // namespace facet
