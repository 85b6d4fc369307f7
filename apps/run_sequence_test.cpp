// SPDX-License-Identifier: BSD-2-Clause
// The run loop with a stand-in for the estimator.
#include "run_sequence.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/io/asl_dataset.h"
#include "facet/io/errors.h"
#include "facet/recording/folder_recording.h"
#include "facet/recording/image_turner.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

/// Remembers what it was fed; poses begin with the third frame.
struct FakeVio {
  std::vector<Timestamp> imu, frames, mono;
  std::vector<Timestamp> newest_imu;  // at each frame
  cv::Mat right;                      // of the last frame that has one
  int first_pose = 2, lost_from = 1000, reset_at = -1;
  int num_seeing_little = 0;  // the first ones with a pose
  std::chrono::milliseconds busy{0};
  bool is_late = false;
  std::string warning;  // with every fifth frame
  std::optional<VioOutput> late;

  VioOutput Process(const StereoFrame& frame) {
    std::this_thread::sleep_for(busy);
    const int i = static_cast<int>(frames.size());
    frames.push_back(frame.t);
    newest_imu.push_back(imu.empty() ? Timestamp{} : imu.back());
    if (frame.right.empty()) mono.push_back(frame.t);
    if (!frame.right.empty()) right = frame.right.clone();
    VioOutput output;
    output.t = frame.t;
    output.has_pose = i >= first_pose && i < lost_from;
    output.status = output.has_pose  ? TrackingStatus::kOk
                    : i < first_pose ? TrackingStatus::kInitialising
                                     : TrackingStatus::kLost;
    output.reason = output.has_pose ? "" : "too few tracks";
    if (output.has_pose && i < first_pose + num_seeing_little) {
      output.status = TrackingStatus::kDegraded;
      output.reason = "few landmarks";
    }
    output.is_keyframe = i % 4 == 0;
    output.was_reset = i == reset_at;
    if (i % 5 == 4) output.warning = warning;
    // Each keyframe leaves the window one keyframe later.
    if (output.is_keyframe && i >= 4) {
      output.finished_keyframes.push_back(
          {FrameId{i - 4}, frames[static_cast<std::size_t>(i - 4)], {}});
    }
    return output;
  }

  /// With `is_late` each output comes with the next call, as from ThreadedVio.
  std::vector<VioOutput> Deliver(const StereoFrame& frame) {
    std::vector<VioOutput> outputs;
    if (is_late && late) outputs.push_back(*late);
    late = Process(frame);
    return is_late ? outputs : std::vector{*late};
  }

  VioFunctions Functions() {
    return {[this](const ImuSample& s) { imu.push_back(s.t); },
            [this](const StereoFrame& f) { return Deliver(f); },
            [this] { return is_late && late ? std::vector{*late} : std::vector<VioOutput>(); },
            [this] {
              const std::size_t last = std::min<std::size_t>(8, frames.size() - 1);
              RunResult result;
              result.window_keyframes = {{FrameId{8}, frames[last], {}}};
              return result;
            },
            nullptr};
  }
};

class RunSequenceTest : public ::testing::Test {
 protected:
  SequenceRun Run(const RunRange& range = {}) {
    FolderRecording recording{AslDataset(Sequence())};
    return RunSequence(
        recording, vio_.Functions(), range, [&](const RunProgress& progress, const VioOutput& out) {
          EXPECT_LE(progress.num_frames, progress.num_expected);
          EXPECT_EQ(progress.newest->t, out.t);
          return progress.num_frames < stop_after_;
        });
  }
  std::filesystem::path Sequence() const { return folder_ / "seq"; }
  std::filesystem::path Image(int camera, int i) const {
    return Sequence() / "mav0" / ("cam" + std::to_string(camera)) / "data" /
           (std::to_string(FrameStamp(options_, i)) + ".pgm");
  }
  void Write() { WriteTestSequence(Sequence(), options_); }

  TempFolder folder_;
  TestSequenceOptions options_;
  FakeVio vio_;
  int stop_after_ = 1 << 30;
};

TEST_F(RunSequenceTest, FeedsEverythingInOrder) {
  Write();
  const SequenceRun run = Run();
  EXPECT_EQ(run.end, RunEnd::kComplete);
  EXPECT_EQ(run.message, "");
  ASSERT_EQ(vio_.frames.size(), 12u);
  // From the sample at the first frame to one beyond the last.
  EXPECT_EQ(vio_.imu.front(), vio_.frames.front());
  for (std::size_t i = 0; i < vio_.frames.size(); ++i) {
    EXPECT_EQ((vio_.newest_imu[i] - vio_.frames[i]).ns, options_.imu_interval_ns);
  }
  EXPECT_TRUE(std::is_sorted(vio_.imu.begin(), vio_.imu.end()));
  EXPECT_EQ(run.record.num_frames, 12);
  EXPECT_EQ(run.record.frames.size(), 12u);
  EXPECT_EQ(run.record.CausalTrajectory().size(), 10u);
  EXPECT_NEAR(*run.record.InitSeconds(), 0.1, 1e-12);
  EXPECT_NEAR(run.record.duration_s, 0.55, 1e-12);
  EXPECT_EQ(run.record.keyframes.size(), 3u);
  EXPECT_GT(run.record.peak_rss_mb, 1);
  EXPECT_EQ(run.record.frames[2].status, "ok");
}

TEST_F(RunSequenceTest, DecodingAheadChangesNothing) {
  options_.num_frames = 30;
  Write();
  for (const int i : {3, 4, 29})
    WriteText(Image(0, i), "P5\n160 120\n255\nshort");
  for (const int i : {6, 17})
    WriteText(Image(1, i), "no image");
  for (const int stop_after : {1 << 30, 9}) {
    stop_after_ = stop_after;
    vio_ = FakeVio();
    const SequenceRun expected = Run();
    const FakeVio alone = std::exchange(vio_, FakeVio());
    RunRange range;
    range.num_decoders = 3;
    const SequenceRun run = Run(range);
    EXPECT_EQ(vio_.frames, alone.frames);
    EXPECT_EQ(vio_.imu, alone.imu);
    EXPECT_EQ(vio_.newest_imu, alone.newest_imu);
    EXPECT_EQ(vio_.mono, alone.mono);
    EXPECT_EQ(cv::countNonZero(vio_.right != alone.right), 0);
    EXPECT_EQ(run.end, expected.end);
    EXPECT_EQ(run.message, expected.message);
    EXPECT_EQ(run.record.warnings, expected.record.warnings);
    EXPECT_EQ(run.record.num_frames, expected.record.num_frames);
    EXPECT_EQ(run.record.num_damaged, expected.record.num_damaged);
    EXPECT_EQ(run.record.num_damaged, stop_after == 9 ? 2 : 3);
  }
}

TEST_F(RunSequenceTest, RightImagesOfAnotherMomentAreTurnedByTheGyroscope) {
  Write();
  EditLines(Sequence() / "mav0/cam1/data.csv", [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i) {
      const std::string file = lines[i].substr(lines[i].find(','));
      lines[i] = std::to_string(std::stoll(lines[i]) + 4000000) + file;
    }
  });
  cv::Mat taken;
  ImageReader().Read(Image(1, 11), taken);
  const auto is_same = [&](const cv::Mat& image) {
    return std::equal(image.begin<char>(), image.end<char>(), vio_.right.begin<char>());
  };
  const SequenceRun rest = Run();
  EXPECT_TRUE(is_same(taken)) << "it hardly turns";
  EXPECT_THAT(rest.record.warnings, ::testing::IsEmpty());

  EditLines(Sequence() / "mav0/imu0/data.csv", [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i] = lines[i].substr(0, lines[i].find(',')) + ",0.5,-0.7,0.9,9.81,0.01,0.02";
  });
  const SequenceRun run = Run();
  EXPECT_THAT(run.record.warnings,
              Contains(AllOf(HasSubstr("12 of 12 right images"), HasSubstr("up to 4.00 ms"))));
  // 4 ms later the body has turned by this; the image becomes that of the body before.
  const Matrix3d R_Bleft_Bright = ExpSO3(0.004 * Vector3d(0.5, -0.7, 0.9)).toRotationMatrix();
  const StereoRig rig = AslDataset(Sequence()).rig();
  const Matrix3d R_BC = rig.T_BC[1].R();
  ImageTurner(rig.cameras[1]).Turn(R_BC.transpose() * R_Bleft_Bright.transpose() * R_BC, taken);
  EXPECT_TRUE(is_same(taken));
}

TEST_F(RunSequenceTest, LateOutputsGiveTheSameRecord) {
  Write();
  vio_.is_late = true;
  const SequenceRun run = Run();
  EXPECT_EQ(run.end, RunEnd::kComplete);
  ASSERT_EQ(run.record.frames.size(), 12u);
  for (int i = 0; i < 12; ++i)
    EXPECT_EQ(run.record.frames[i].t.ns, FrameStamp(options_, i));
  EXPECT_EQ(run.record.CausalTrajectory().size(), 10u);
  EXPECT_EQ(run.record.keyframes.size(), 3u);
}

TEST_F(RunSequenceTest, TimeOffsetMovesTheImu) {
  Write();
  for (int i = 0; i < 2; ++i) {
    const auto yaml = Sequence() / "mav0" / ("cam" + std::to_string(i)) / "sensor.yaml";
    ReplaceInFile(yaml, "rate_hz: 20", "timeshift_cam_imu: 0.0125");
  }
  Run();
  // 12.5 ms lies between two samples: the one before the first frame is fed, too.
  EXPECT_EQ((vio_.imu.front() - vio_.frames.front()).ns, 10000000);
  EXPECT_EQ((vio_.newest_imu[3] - vio_.frames[3]).ns, 15000000);
}

TEST_F(RunSequenceTest, StartDurationAndImuHistory) {
  Write();
  RunRange range;
  range.start_s = 0.2;
  range.duration_s = 0.15;
  range.imu_history_s = 0.05;
  const SequenceRun run = Run(range);
  ASSERT_EQ(vio_.frames.size(), 4u);
  EXPECT_EQ(vio_.frames.front().ns, FrameStamp(options_, 4));
  EXPECT_EQ((vio_.frames.front() - vio_.imu.front()).ns, 50000000);
  EXPECT_EQ(run.record.first_pair.ns, FrameStamp(options_, 4));
  EXPECT_EQ(run.record.num_frames, 4);
  range.start_s = 7;
  EXPECT_THROW(Run(range), ConfigError);
}

TEST_F(RunSequenceTest, DamagedImagesAreSkippedAndReported) {
  Write();
  Truncate(Image(0, 5), 500);
  Truncate(Image(1, 7), 500);
  const SequenceRun run = Run();
  EXPECT_EQ(run.end, RunEnd::kComplete);
  EXPECT_EQ(vio_.frames.size(), 11u);
  EXPECT_EQ(run.record.num_damaged, 1);
  ASSERT_EQ(vio_.mono.size(), 1u);
  EXPECT_EQ(vio_.mono[0].ns, FrameStamp(options_, 7));
  EXPECT_THAT(run.record.warnings, Contains(HasSubstr("1 of 12 left images are unusable")));
  EXPECT_THAT(run.record.warnings, Contains(HasSubstr("left image only")));
}

TEST_F(RunSequenceTest, ManyDamagedImagesInARowAreLikeMissingOnes) {
  options_.num_frames = 60;
  Write();
  for (int i = 10; i < 50; ++i) {
    Truncate(Image(0, i), 500);
    Truncate(Image(1, i), 500);
  }
  const SequenceRun run = Run();
  EXPECT_EQ(run.end, RunEnd::kComplete);
  EXPECT_EQ(vio_.frames.size(), 20u);
  EXPECT_EQ(run.record.num_damaged, 40);
  ASSERT_EQ(run.record.warnings.size(), 1u);
  EXPECT_THAT(
      run.record.warnings[0],
      AllOf(HasSubstr("40 of 60 left images"), HasSubstr(Image(0, 10)), HasSubstr("truncated")));
}

TEST_F(RunSequenceTest, DamageAtTheBeginningOfThePart) {
  options_.num_frames = 30;
  Write();
  for (int i = 0; i < 8; ++i)
    Truncate(Image(0, i), 500);
  const SequenceRun run = Run();
  EXPECT_EQ(run.end, RunEnd::kComplete);
  EXPECT_EQ(run.record.num_damaged, 8);
  EXPECT_EQ(vio_.frames.front().ns, FrameStamp(options_, 8));
}

TEST_F(RunSequenceTest, NoReadableImageInThePartIsAnInputError) {
  options_.num_frames = 30;
  Write();
  for (int i = 10; i < 30; ++i)
    Truncate(Image(0, i), 500);
  RunRange range;
  range.start_s = 0.5;
  try {
    Run(range);
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(Image(0, 10)), HasSubstr("like all 20 left images")));
  }
}

TEST_F(RunSequenceTest, NeverStarted) {
  Write();
  vio_.first_pose = 1000;
  const SequenceRun run = Run();
  EXPECT_EQ(run.end, RunEnd::kNotStarted);
  EXPECT_THAT(run.message, HasSubstr("could not start: too few tracks"));
  EXPECT_FALSE(run.record.InitSeconds());
}

TEST_F(RunSequenceTest, LostAtTheEndIsNoSuccess) {
  options_.num_frames = 40;
  Write();
  vio_.lost_from = 15;
  EXPECT_EQ(Run().end, RunEnd::kLost);
  vio_ = FakeVio();
  vio_.lost_from = 39;
  EXPECT_EQ(Run().end, RunEnd::kLost) << "also if it is only the last frame";
}

TEST_F(RunSequenceTest, WarningsOfTheEstimator) {
  Write();
  EXPECT_TRUE(Run().record.warnings.empty());
  vio_ = FakeVio();
  vio_.warning = "are the cameras swapped?";
  vio_.reset_at = 6;
  EXPECT_THAT(Run().record.warnings,
              ::testing::ElementsAre("are the cameras swapped? (2 times, the last at 0.5 s)",
                                     HasSubstr("started over 1 times, the last at 0.3 s: a new")));
}

TEST_F(RunSequenceTest, SomeFramesThatSeeLittleAreTold) {
  Write();
  vio_.num_seeing_little = 4;
  EXPECT_TRUE(Run().record.warnings.empty());
  vio_ = FakeVio();
  vio_.num_seeing_little = 5;
  EXPECT_THAT(Run().record.warnings,
              ::testing::ElementsAre(HasSubstr("5 of 12 frames saw few landmarks")));
}

TEST_F(RunSequenceTest, StopsWhenAskedTo) {
  Write();
  stop_after_ = 6;
  const SequenceRun run = Run();
  EXPECT_EQ(run.end, RunEnd::kStopped);
  EXPECT_EQ(run.record.frames.size(), 6u);
  EXPECT_THAT(run.message, HasSubstr("after 6 of 12 frames"));
}

TEST_F(RunSequenceTest, RealTimeDropsWhatArrivesWhileBusy) {
  Write();
  vio_.busy = std::chrono::milliseconds(120);
  RunRange range;
  range.realtime = true;
  const SequenceRun run = Run(range);
  EXPECT_GE(run.record.num_dropped, 5);
  EXPECT_EQ(run.record.num_dropped + static_cast<int>(vio_.frames.size()), 12);
  EXPECT_TRUE(std::is_sorted(vio_.frames.begin(), vio_.frames.end()));
  EXPECT_GE(run.record.wall_s, 0.55);
  EXPECT_GE(run.record.frames[0].latency_ms, 119);
}

}  // namespace
}  // namespace facet
