// SPDX-License-Identifier: BSD-2-Clause
// The odometry between the threads of a running system. Also for the thread sanitizer.
#include "facet/live/live_vio.h"

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "facet/pipeline/vio_pipeline.h"
#include "facet/testing/pipeline/painted_recording.h"

namespace facet {
namespace {

using testing::kImuInterval;
using testing::PaintedRecording;

class LiveVioTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { recording_ = new PaintedRecording(testing::PaintRecording()); }
  static void TearDownTestSuite() { delete recording_; }

  static LiveOptions NothingIsDropped() {
    LiveOptions options;
    options.max_waiting_frames = recording_->frames.size();
    options.max_imu_wait_s = 60;
    return options;
  }

  static void FeedTo(LiveVio& live) {
    testing::Feed(
        *recording_,
        [&](const ImuSample& sample) { live.AddImu(sample); },
        [&](const StereoFrame& frame) { live.AddStereo(frame); });
  }

  static inline PaintedRecording* recording_ = nullptr;
};

TEST_F(LiveVioTest, GivesTheBytesOfThePipelineFromTwoThreads) {
  std::vector<VioOutput> expected;
  VioPipeline pipeline(recording_->rig, ImuNoise{}, VioOptions{});
  testing::Feed(
      *recording_,
      [&](const ImuSample& sample) { pipeline.AddImu(sample); },
      [&](const StereoFrame& frame) { expected.push_back(pipeline.AddStereo(frame)); });
  for (const bool two_threads : {false, true}) {
    SCOPED_TRACE(two_threads);
    LiveOptions options = NothingIsDropped();
    options.two_threads = two_threads;
    std::vector<VioOutput> outputs;
    std::atomic<int> num_poses = 0;
    LiveVio live(
        recording_->rig,
        ImuNoise{},
        VioOptions{},
        options,
        [&](const VioOutput& output) { num_poses += output.has_pose ? 1 : 0; },
        [&](const VioOutput& output) { outputs.push_back(output); });
    std::thread images([&] {
      for (const StereoFrame& frame : recording_->frames)
        live.AddStereo(frame);
    });
    std::atomic<bool> is_over = false;
    int num_predicted = 0;
    std::thread controller([&] {
      while (!is_over) {
        const auto state = live.PredictAt(recording_->imu.back().t);
        num_predicted += state ? 1 : 0;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
    for (const ImuSample& sample : recording_->imu)
      live.AddImu(sample);
    images.join();
    const RunResult result = live.Finish();
    is_over = true;
    controller.join();

    const LiveCounts counts = live.counts();
    EXPECT_EQ(counts.frames, static_cast<std::int64_t>(recording_->frames.size()));
    EXPECT_EQ(counts.done_frames, counts.frames);
    EXPECT_EQ(counts.dropped_frames + counts.dropped_imu, 0);
    EXPECT_EQ(counts.imu, static_cast<std::int64_t>(recording_->imu.size()));
    EXPECT_GT(counts.latency_s, 0);
    EXPECT_GT(num_poses, 40);
    EXPECT_GT(num_predicted, 0);
    ASSERT_EQ(outputs.size(), expected.size());
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      EXPECT_EQ(outputs[i].t, expected[i].t);
      EXPECT_EQ(outputs[i].has_pose, expected[i].has_pose);
      EXPECT_EQ(outputs[i].state.T_WB.p, expected[i].state.T_WB.p);
      EXPECT_EQ(outputs[i].sigma_p, expected[i].sigma_p);
      EXPECT_EQ(outputs[i].causal.covariance, expected[i].causal.covariance);
    }
    ASSERT_TRUE(result.map);
    EXPECT_EQ(result.map->vertices, pipeline.Result().map->vertices);
  }
}

TEST_F(LiveVioTest, TellsThatACallbackHasThrown) {
  LiveVio live(recording_->rig, ImuNoise{}, VioOptions{}, NothingIsDropped(), [](const VioOutput&) {
    throw std::runtime_error("the controller's");
  });
  EXPECT_FALSE(live.counts().has_failed);
  FeedTo(live);
  EXPECT_THROW(live.Finish(), std::runtime_error);
  EXPECT_TRUE(live.counts().has_failed);
}

// One damaged stamp of a camera costs one frame.
TEST_F(LiveVioTest, AStampFarInTheFutureDoesNotEndIt) {
  LiveOptions options = NothingIsDropped();
  options.max_imu_wait_s = 0.05;
  int num_poses = 0;
  LiveVio live(recording_->rig, ImuNoise{}, VioOptions{}, options, [&](const VioOutput& output) {
    num_poses += output.has_pose ? 1 : 0;
  });
  int number = 0;
  testing::Feed(
      *recording_,
      [&](const ImuSample& sample) { live.AddImu(sample); },
      [&](StereoFrame frame) {
        if (++number == 20) frame.t = frame.t + FromSeconds(1000);
        live.AddStereo(frame);
      });
  live.Finish();
  EXPECT_GT(num_poses, 30);
}

TEST_F(LiveVioTest, PredictsFromTheNewestFrame) {
  VioOutput last;
  LiveVio live(
      recording_->rig, ImuNoise{}, VioOptions{}, NothingIsDropped(), [&](const VioOutput& output) {
        last = output;
      });
  EXPECT_FALSE(live.PredictAt(recording_->frames[0].t));
  FeedTo(live);
  live.Finish();
  const Timestamp t_imu = last.t + recording_->rig.time_offset;
  const auto at_frame = live.PredictAt(t_imu);
  ASSERT_TRUE(at_frame);
  EXPECT_EQ(at_frame->T_WF.p, last.causal.x.T_WB.p);
  EXPECT_EQ(at_frame->covariance, last.causal.covariance);
  // The state of the frame is the same moved by what is learnt of the clocks' offset.
  EXPECT_LT((at_frame->T_WF.p - last.state.T_WB.p).norm(), 1e-3);
  EXPECT_LT((at_frame->covariance.diagonal().segment<3>(3).cwiseSqrt() - last.sigma_p).norm(),
            0.2 * last.sigma_p.norm());
  const auto later = live.PredictAt(t_imu + kImuInterval);
  ASSERT_TRUE(later);
  const Vector3d moved = later->T_WF.p - at_frame->T_WF.p;
  EXPECT_LT((moved - ToSeconds(kImuInterval) * at_frame->v_WF).norm(), 1e-4);
  EXPECT_EQ(later->status, TrackingStatus::kOk);
}

TEST_F(LiveVioTest, DropsTheOldestFrameAndCountsIt) {
  LiveOptions options;
  options.max_waiting_frames = 2;
  options.max_imu_wait_s = 60;
  std::vector<Timestamp> done;
  LiveVio live(recording_->rig, ImuNoise{}, VioOptions{}, options, [&](const VioOutput& output) {
    done.push_back(output.t);
  });
  // Without IMU none of them can be worked on.
  for (int i = 0; i < 5; ++i)
    live.AddStereo(recording_->frames[static_cast<std::size_t>(i)]);
  live.Finish();
  EXPECT_EQ(live.counts().frames, 5);
  EXPECT_EQ(live.counts().dropped_frames, 3);
  EXPECT_EQ(live.counts().late_imu_frames, 2);
  ASSERT_EQ(done.size(), 2u);
  EXPECT_EQ(done[0], recording_->frames[3].t);
  EXPECT_EQ(done[1], recording_->frames[4].t);
  live.AddStereo(recording_->frames[5]);
  live.AddImu(recording_->imu[0]);
  EXPECT_EQ(live.counts().dropped_frames, 4) << "after the end";
  EXPECT_EQ(live.counts().dropped_imu, 1);
}

TEST_F(LiveVioTest, DropsTheOldestSamplesAndCountsThem) {
  LiveOptions options;
  options.max_waiting_imu = 100;
  LiveVio live(recording_->rig, ImuNoise{}, VioOptions{}, options);
  for (int i = 0; i < 150; ++i)
    live.AddImu(recording_->imu[static_cast<std::size_t>(i)]);
  EXPECT_EQ(live.counts().imu, 150);
  EXPECT_EQ(live.counts().dropped_imu, 50);
}

TEST_F(LiveVioTest, AFrameDoesNotWaitForADeadImu) {
  LiveOptions options;
  options.max_imu_wait_s = 0.02;
  std::atomic<int> num_done = 0;
  LiveVio live(
      recording_->rig, ImuNoise{}, VioOptions{}, options, [&](const VioOutput&) { ++num_done; });
  live.AddStereo(recording_->frames[0]);
  for (int i = 0; i < 2000 && num_done == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(num_done, 1);
}

TEST_F(LiveVioTest, EndsWithoutFinish) {
  LiveVio live(recording_->rig, ImuNoise{}, VioOptions{}, NothingIsDropped());
  FeedTo(live);
  EXPECT_EQ(live.counts().dropped_frames, 0);
}

}  // namespace
}  // namespace facet
