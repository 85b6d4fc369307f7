// SPDX-License-Identifier: BSD-2-Clause
// What the two halves of a frame tell each other around a reset, and what the front half keeps.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "facet/pipeline/front_stage.h"
#include "facet/pipeline/pose_stage.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"

namespace facet {
namespace {

constexpr Timestamp kBegin{1'400'000'000'000'000'000};
constexpr Duration kFrameInterval{50'000'000};
constexpr Duration kImuInterval{5'000'000};

VioOptions WithoutMesh() {
  VioOptions options;
  options.mesh.enabled = false;
  return options;
}

/// A front stage that sees nothing but grey, with IMU at 200 Hz.
class FrontStageTest : public ::testing::Test {
 protected:
  TrackedFrame Next() {
    frame_.t = frame_.t + kFrameInterval;
    FeedImuUntil(frame_.t + kImuInterval);
    return front_->Track(frame_, front_->Predict(frame_.t));
  }
  void FeedImuUntil(Timestamp t) {
    for (; t_imu_ <= t; t_imu_ = t_imu_ + kImuInterval)
      front_->AddImu({t_imu_, Vector3d::Zero(), Vector3d(0, 0, gravity_)});
  }
  Feedback FeedbackOf(const TrackedFrame& tracked) const {
    Feedback feedback;
    feedback.frame = tracked.frontend.observations.frame;
    feedback.state.t = tracked.frontend.observations.t;
    return feedback;
  }

  StereoRig rig_ = EurocRig();
  double gravity_ = kGravity;
  std::optional<FrontStage> front_{std::in_place, rig_, WithoutMesh()};
  StereoFrame frame_{kBegin,
                     cv::Mat(rig_.cameras[0].height(), rig_.cameras[0].width(), CV_8UC1, 99.0),
                     cv::Mat(rig_.cameras[1].height(), rig_.cameras[1].width(), CV_8UC1, 99.0)};
  Timestamp t_imu_ = kBegin;
};

TEST_F(FrontStageTest, KeepsLittleImuWhileNothingComesBack) {
  for (int i = 0; i < 100; ++i) {
    const TrackedFrame tracked = Next();
    EXPECT_EQ(tracked.imu.samples.size(), 11u) << i;
    EXPECT_LE(front_->num_imu_samples(), 25u) << i;
  }
}

TEST_F(FrontStageTest, ADeadAxisOfTheImuIsAWarningOnce) {
  int num_warnings = 0;
  for (int i = 0; i < 200; ++i) {
    for (const Timestamp end = frame_.t + kFrameInterval + kImuInterval; t_imu_ <= end;
         t_imu_ = t_imu_ + kImuInterval) {
      const double s = ToSeconds(t_imu_ - kBegin);
      const Vector3d waves(std::sin(3 * s), std::sin(4 * s), std::cos(3 * s));
      front_->AddImu({t_imu_, 0.5 * waves, Vector3d(waves.x(), 0, 9.81 + waves.y())});
    }
    const TrackedFrame tracked = Next();
    if (tracked.warning.empty()) continue;
    ++num_warnings;
    EXPECT_NE(tracked.warning.find("axis y of the accelerometer has sent 0 m/s^2"),
              std::string::npos);
  }
  EXPECT_EQ(num_warnings, 1);
}

TEST_F(FrontStageTest, FeedbackReachesBackToItsFrame) {
  for (int i = 0; i < 40; ++i) {
    const TrackedFrame tracked = Next();
    EXPECT_EQ(tracked.used_feedback, i >= 3) << i;
    // Every fifth frame is a keyframe after the first one.
    if (i == 1 || i % 5 == 4) front_->AddFeedback(FeedbackOf(tracked));
  }
}

TEST_F(FrontStageTest, PredictsAndJudgesWithTheGravityOfTheOptions) {
  gravity_ = 3.71;
  VioOptions options = WithoutMesh();
  for (const bool is_set : {false, true}) {
    if (is_set) options.estimator.imu.gravity_mps2 = gravity_;
    front_.emplace(rig_, options);
    bool is_refused = false;
    double largest_m = 0;
    for (int i = 0; i < 60; ++i) {
      if (i % 5 == 4) front_->AddFeedback(FeedbackOf(Next()));
      frame_.t = frame_.t + kFrameInterval;
      FeedImuUntil(frame_.t + kImuInterval);
      MotionPrediction prediction = front_->Predict(frame_.t);
      largest_m = std::max(largest_m, prediction.hint.p_prev_now.norm());
      is_refused = is_refused || !front_->Track(frame_, std::move(prediction)).refusal.empty();
    }
    EXPECT_EQ(is_refused, !is_set);
    if (is_set) {
      EXPECT_LT(largest_m, 1e-9) << "at rest";
    } else {
      EXPECT_GT(largest_m, 0.01);
    }
  }
}

TEST_F(FrontStageTest, AFrameOutOfOrderLeavesNoTrace) {
  for (int i = 0; i < 5; ++i)
    Next();
  for (const Duration back : {Duration{0}, Duration{30'000'000}, Duration{500'000'000}}) {
    StereoFrame late = frame_;
    late.t = frame_.t - back;
    const TrackedFrame refused = front_->Track(late, front_->Predict(late.t));
    EXPECT_FALSE(refused.frontend.in_order);
    EXPECT_TRUE(refused.frontend.observations.features.empty());
    const TrackedFrame next = Next();
    EXPECT_TRUE(next.frontend.in_order);
    ASSERT_EQ(next.imu.samples.size(), 11u) << "the interval begins at the newest frame";
    EXPECT_EQ(next.imu.samples.front().t, frame_.t - kFrameInterval + rig_.time_offset);
  }
}

// One damaged stamp would otherwise make everything behind it too late, for good.
TEST_F(FrontStageTest, AFrameFarAheadOfEverythingIsNotUsed) {
  for (int i = 0; i < 5; ++i)
    Next();
  StereoFrame stray = frame_;
  stray.t = frame_.t + FromSeconds(1000);
  EXPECT_TRUE(front_->Track(stray, front_->Predict(stray.t)).is_stray);
  const TrackedFrame next = Next();
  EXPECT_FALSE(next.is_stray);
  EXPECT_TRUE(next.frontend.in_order);
  ASSERT_EQ(next.imu.samples.size(), 11u) << "the interval begins at the newest frame";
}

// The IMU may have ended, and the clocks go on.
TEST_F(FrontStageTest, ThreeFramesThatAgreeAreNoStrays) {
  for (int i = 0; i < 5; ++i)
    Next();
  StereoFrame ahead = frame_;
  for (int i = 0; i < 5; ++i) {
    ahead.t = frame_.t + FromSeconds(1000 + 0.05 * i);
    EXPECT_EQ(front_->Track(ahead, front_->Predict(ahead.t)).is_stray, i < 2) << i;
  }
}

// A pause of everything, and one of the cameras alone, are no reason.
TEST_F(FrontStageTest, AfterAPauseFramesAreUsedAtOnce) {
  for (int i = 0; i < 5; ++i)
    Next();
  frame_.t = frame_.t + FromSeconds(3);
  EXPECT_FALSE(Next().is_stray);
  frame_.t = t_imu_ = frame_.t + FromSeconds(3);
  EXPECT_FALSE(Next().is_stray);
}

TEST_F(FrontStageTest, ForgetsWhatWasKnownBeforeAReset) {
  front_->AddFeedback(FeedbackOf(Next()));
  Next();
  EXPECT_TRUE(Next().used_feedback);
  Feedback reset = FeedbackOf(Next());
  reset.is_reset = true;
  front_->AddFeedback(reset);
  EXPECT_TRUE(Next().used_feedback) << "the same delay as for everything else";
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(Next().used_feedback) << i;
    EXPECT_LE(front_->num_imu_samples(), 25u) << i;
  }
  front_->AddFeedback(FeedbackOf(Next()));
  Next();
  EXPECT_TRUE(Next().used_feedback);
}

TEST_F(FrontStageTest, KeepsTheLastMinutesOfImuBeforeTheFirstFrame) {
  FeedImuUntil(kBegin + FromSeconds(900));
  const auto kept = static_cast<std::size_t>(FrontStage::kLongestHistory.ns / kImuInterval.ns);
  EXPECT_LE(front_->num_imu_samples(), kept + 1);
  frame_.t = kBegin + FromSeconds(900);
  EXPECT_EQ(Next().imu.samples.back().t, frame_.t);
}

/// What the front stage says of five seconds of a flight.
struct SimulatedFront {
  SimulatedRun run;
  ImuBuffer imu;

  SimulatedFront() {
    FeatureSimulatorOptions options;
    options.max_tracks = 70;
    options.duration_s = 5;
    run = SimulateFeatures(SplineTrajectory::Fit(MakeFlight(10, 2)), EurocRig(), options, 1);
    for (const ImuSample& sample : run.imu)
      imu.Add(sample);
  }

  TrackedFrame Tracked(std::size_t i) const {
    TrackedFrame tracked;
    tracked.frontend.observations = run.frames[i];
    tracked.imu =
        imu.Between(run.truth[i - 1].t, run.truth[i].t, Duration{20'000'000}, Duration{0});
    return tracked;
  }
};

TEST(PoseStageTest, TellsTheFrontStageOfAReset) {
  const SimulatedFront front;
  PoseStage pose(front.run.rig, ImuNoise{}, WithoutMesh());
  int num_resets = 0, num_feedbacks = 0;
  for (std::size_t i = 1; i < front.run.frames.size(); ++i) {
    TrackedFrame tracked = front.Tracked(i);
    // In the dark the body is thrown away.
    if (i > 60) tracked.frontend.observations.features.clear();
    for (std::size_t k = 1; i > 60 && k < tracked.imu.samples.size(); ++k)
      tracked.imu.samples[k].accel.x() += 500;
    const VioOutput output = pose.Estimate(tracked);
    num_resets += output.was_reset ? 1 : 0;
    const std::optional<Feedback> feedback = pose.TakeFeedback();
    if (!feedback) continue;
    ++num_feedbacks;
    EXPECT_EQ(feedback->is_reset, output.was_reset) << i;
  }
  EXPECT_GE(num_resets, 1);
  EXPECT_GT(num_feedbacks, num_resets);
}

TEST(PoseStageTest, SaysWhyAStrayFrameHasNoPose) {
  PoseStage stage(EurocRig(), ImuNoise{}, WithoutMesh());
  TrackedFrame frame;
  frame.is_stray = true;
  frame.frontend.observations.t = kBegin + FromSeconds(1000);
  const VioOutput out = stage.Estimate(frame);
  EXPECT_FALSE(out.has_pose);
  EXPECT_EQ(out.t, frame.frontend.observations.t);
  EXPECT_EQ(out.reason, "stamp is far ahead of all others");
}

TEST(PoseStageTest, KeyframesHaveNoPosesBeforeTheStart) {
  const SimulatedFront front;
  PoseStage pose(front.run.rig, ImuNoise{}, WithoutMesh());
  int num_before = 0, num_after = 0;
  for (std::size_t i = 1; i < 60; ++i) {
    TrackedFrame tracked = front.Tracked(i);
    const bool has_started = pose.Estimate(tracked).has_pose;
    ++(has_started ? num_after : num_before);
    EXPECT_EQ(pose.WindowKeyframes().empty(), !has_started) << i;
  }
  EXPECT_GT(num_before, 3);
  EXPECT_GT(num_after, 3);
}

}  // namespace
}  // namespace facet
