// SPDX-License-Identifier: BSD-2-Clause
// `facet convert`: what is read back is what was there, and an interrupted conversion goes on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/recording/open_recording.h"
#include "facet/testing/data_dir.h"
#include "facet/testing/io/program_run.h"
#include "facet/testing/recording/test_bags.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class ConvertTest : public ::testing::Test {
 protected:
  ConvertTest() {
    WriteTestSequence(Sequence());
    std::vector<TestMessage> messages =
        CalibrationMessagesOfSequence(Sequence(), MessageEncoding::kCdr);
    for (TestMessage& message : MessagesOfSequence(Sequence(), MessageEncoding::kCdr))
      messages.push_back(std::move(message));
    bytes_ = McapBytes(messages);
    WriteText(folder_ / "a.mcap", bytes_);
  }
  std::filesystem::path Sequence() const { return folder_ / "seq"; }
  std::filesystem::path Out() const { return folder_ / "out"; }
  ProgramRun Convert() const { return Convert("a.mcap", "out"); }
  ProgramRun Convert(const std::string& from,
                     const std::string& to,
                     const std::string& more = "") const {
    return RunFacet("convert " + (folder_ / from).string() + " " + (folder_ / to).string() + more);
  }

  TempFolder folder_;
  std::string bytes_;
};

TEST_F(ConvertTest, TheFolderHoldsWhatTheBagHolds) {
  const ProgramRun run = Convert();
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto original = OpenRecording(Sequence()), converted = OpenRecording(Out());
  ImageReader reader;
  cv::Mat a, b;
  int num_frames = 0, num_samples = 0;
  while (const auto expected = original->Next()) {
    const auto event = converted->Next();
    ASSERT_TRUE(event);
    ASSERT_EQ(event->index(), expected->index());
    if (const auto* sample = std::get_if<ImuSample>(&*expected)) {
      const auto& other = std::get<ImuSample>(*event);
      EXPECT_EQ(other.t, sample->t);
      EXPECT_EQ(other.gyro, sample->gyro);
      EXPECT_EQ(other.accel, sample->accel);
      ++num_samples;
      continue;
    }
    const auto& frame = std::get<RecordedFrame>(*expected);
    const auto& other = std::get<RecordedFrame>(*event);
    EXPECT_EQ(other.t, frame.t);
    ASSERT_TRUE(other.HasRight());
    frame.right->Decode({}, reader, a);
    other.right->Decode({}, reader, b);
    ASSERT_EQ(a.size(), b.size());
    EXPECT_TRUE(std::equal(a.begin<char>(), a.end<char>(), b.begin<char>()));
    ++num_frames;
  }
  EXPECT_FALSE(converted->Next());
  EXPECT_EQ(num_frames, 12);
  EXPECT_GT(num_samples, 100);
  const StereoRig& rig = converted->calibration()->rig;
  EXPECT_NEAR(rig.baseline_m(), original->calibration()->rig.baseline_m(), 1e-9);
}

TEST_F(ConvertTest, AnInterruptedConversionGoesOn) {
  ASSERT_EQ(Convert().exit_code, 0);
  EXPECT_EQ(Convert().exit_code, 2) << "it is complete";
  std::filesystem::remove(Out() / "mav0/imu0/data.csv");
  std::filesystem::remove(Out() / "mav0/cam0/data" /
                          (std::to_string(FrameStamp(TestSequenceOptions(), 3)) + ".png"));
  const ProgramRun again = Convert();
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("12 frames (23 images were there already"));
  EXPECT_EQ(RunFacet("info " + Out().string()).exit_code, 0);
}

// As Ctrl-C does, which shells keep from what runs in the background.
TEST_F(ConvertTest, APoliteKillSaysWhatIsThere) {
  const auto recording = testing::DataDir("euroc_mh01_handheld");
  if (!recording) GTEST_SKIP() << testing::MissingData("euroc_mh01_handheld");
  const auto interrupt = [&](const std::string& out, const std::string& first) {
    const std::string folder = folder_.path().string() + "/";
    return RunShell("(" + std::string(FACET_PROGRAM) + " convert " + recording->string() + " " +
                    folder + out + " & while ! ls " + folder + first +
                    " >/dev/null 2>&1; do sleep 0.01; done; kill $!; wait $!)");
  };
  const ProgramRun folder = interrupt("part", "part/mav0/cam0/data/*.png");
  EXPECT_EQ(folder.exit_code, 130) << folder.err;
  EXPECT_THAT(folder.err, HasSubstr("the same command goes on from here"));
  const ProgramRun mcap = interrupt("part.mcap", "part.mcap.partial");
  EXPECT_EQ(mcap.exit_code, 130) << mcap.err;
  EXPECT_THAT(mcap.err, HasSubstr("nothing was written"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "part.mcap.partial"));
}

TEST_F(ConvertTest, McapHoldsWhatTheFolderHolds) {
  for (const char* compression : {"zstd", "none"}) {
    const std::string file = std::string(compression) + ".mcap";
    const ProgramRun run = Convert("seq", file, " --compression " + std::string(compression));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(Convert("seq", file).exit_code, 2) << "it is there already";
    const auto original = OpenRecording(Sequence()), converted = OpenRecording(folder_ / file);
    ImageReader reader;
    cv::Mat a, b;
    while (const auto expected = original->Next()) {
      const auto event = converted->Next();
      ASSERT_TRUE(event);
      ASSERT_EQ(event->index(), expected->index());
      if (const auto* sample = std::get_if<ImuSample>(&*expected)) {
        EXPECT_EQ(std::get<ImuSample>(*event).t, sample->t);
        EXPECT_EQ(std::get<ImuSample>(*event).gyro, sample->gyro);
        EXPECT_EQ(std::get<ImuSample>(*event).accel, sample->accel);
        continue;
      }
      const auto &frame = std::get<RecordedFrame>(*expected),
                 &other = std::get<RecordedFrame>(*event);
      EXPECT_EQ(other.t, frame.t);
      ASSERT_TRUE(other.HasRight());
      frame.right->Decode({}, reader, a);
      other.right->Decode({}, reader, b);
      ASSERT_EQ(a.size(), b.size());
      EXPECT_TRUE(std::equal(a.begin<char>(), a.end<char>(), b.begin<char>()));
    }
    EXPECT_FALSE(converted->Next());
    const StereoRig &rig = converted->calibration()->rig, &other = original->calibration()->rig;
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(rig.cameras[i].intrinsics().coefficients,
                other.cameras[i].intrinsics().coefficients);
      EXPECT_EQ(rig.cameras[i].intrinsics().fy, other.cameras[i].intrinsics().fy);
      EXPECT_LT((rig.T_BC[i].R() - other.T_BC[i].R()).norm(), 1e-12);
      EXPECT_EQ(rig.T_BC[i].p, other.T_BC[i].p);
    }
  }
}

TEST_F(ConvertTest, AnOffsetOfTheClocksIsNamedBecauseMcapHasNoPlaceForIt) {
  for (const char* camera : {"cam0", "cam1"}) {
    ReplaceInFile(
        Sequence() / "mav0" / camera / "sensor.yaml", "rate_hz: 20", "timeshift_cam_imu: 0.0125");
  }
  const ProgramRun run = Convert("seq", "b.mcap");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.err, AllOf(HasSubstr("+0.012500 s"), HasSubstr("--calibration")));
}

TEST_F(ConvertTest, OtherFoldersAreLeftAlone) {
  WriteText(Out() / "letter.txt", "dear");
  EXPECT_EQ(Convert().exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(Out() / "mav0"));
}

TEST_F(ConvertTest, OfADamagedBagThePartBeforeIsKept) {
  WriteText(folder_ / "a.mcap", bytes_.substr(0, bytes_.size() * 2 / 3));
  const ProgramRun run = Convert();
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, AllOf(HasSubstr("at byte"), HasSubstr("what came before was converted")));
  EXPECT_THAT(RunFacet("info " + Out().string()).out, HasSubstr("stereo pairs"));
}

}  // namespace
}  // namespace facet
