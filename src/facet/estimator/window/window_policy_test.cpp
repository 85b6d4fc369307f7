// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/window_policy.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

// Frames in a row along x; landmark l is seen in frames seen_in[l], with depth.
SlidingWindow WindowAt(const std::vector<double>& positions,
                       const std::vector<std::vector<int>>& seen_in) {
  SlidingWindow window;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    WindowFrame frame;
    frame.id = FrameId{static_cast<std::int64_t>(i)};
    frame.is_keyframe = true;
    frame.x.T_WB.p.x() = positions[i];
    window.frames.push_back(frame);
  }
  for (std::size_t l = 0; l < seen_in.size(); ++l) {
    WindowLandmark& landmark =
        window.AddLandmark(LandmarkId{static_cast<std::int64_t>(l)}, seen_in[l][0]);
    landmark.has_depth = true;
    landmark.inverse_distance = 0.3;
    for (int frame : seen_in[l]) {
      WindowObservation o;
      o.frame = frame;
      landmark.observations.push_back(o);
    }
  }
  return window;
}

std::vector<int> AllFrames(int n) {
  std::vector<int> all;
  for (int i = 0; i < n; ++i)
    all.push_back(i);
  return all;
}

int Count(const std::vector<char>& flags) {
  return static_cast<int>(std::count(flags.begin(), flags.end(), 1));
}

TEST(WindowPolicyTest, AFrameThatSharesNothingIsTheMostRedundant) {
  // Frame 2 sees only a landmark of its own.
  SlidingWindow window = WindowAt({0, 1, 2, 3, 4}, {{0, 1, 3, 4}, {0, 1, 3, 4}, {2}});
  EXPECT_EQ(MostRedundantFrame(window, 0, 3, 0.05), 2);
}

TEST(WindowPolicyTest, AFrameInACrowdIsTheMostRedundant) {
  // Frames 1 and 2 are close together; 1 is the farther from the newest.
  SlidingWindow window = WindowAt({0, 2.0, 2.05, 4, 6}, {AllFrames(5), AllFrames(5)});
  EXPECT_EQ(MostRedundantFrame(window, 0, 3, 0.05), 1);
  EXPECT_EQ(MostRedundantFrame(window, 2, 3, 0.05), 2);
}

TEST(WindowPolicyTest, DuplicatesStandAtTheSamePlaceAndSeeTheSame) {
  const std::vector<std::vector<int>> all(10, AllFrames(3));
  EXPECT_TRUE(IsDuplicate(WindowAt({0, 0.001, 1}, all), 0));
  EXPECT_FALSE(IsDuplicate(WindowAt({0, 0.5, 1}, all), 0));
  std::vector<std::vector<int>> half = all;
  for (int l = 0; l < 5; ++l)
    half[l] = {0, 2};
  EXPECT_FALSE(IsDuplicate(WindowAt({0, 0.001, 1}, half), 0));
  // A frame that sees nothing has nothing to lose.
  EXPECT_TRUE(IsDuplicate(WindowAt({0, 1, 2}, {{0, 1}}), 2));
}

TEST(WindowPolicyTest, NothingLeavesBeforeTheWindowIsFull) {
  WindowOptions options;
  std::vector<double> positions(options.max_full_keyframes);
  for (std::size_t i = 0; i < positions.size(); ++i)
    positions[i] = 0.1 * static_cast<double>(i);
  const SlidingWindow window = WindowAt(positions, {AllFrames(options.max_full_keyframes)});
  EXPECT_TRUE(PlanMarginalization(window, options).IsEmpty());
}

TEST(WindowPolicyTest, TheOldestMotionLeavesFirst) {
  WindowOptions options;
  options.max_full_keyframes = 3;
  SlidingWindow window = WindowAt({0, 1, 2, 3}, {AllFrames(4)});
  MarginalizationPlan plan = PlanMarginalization(window, options);
  EXPECT_EQ(plan.drop_motion, std::vector<char>({1, 0, 0, 0}));
  EXPECT_EQ(Count(plan.drop_frame) + Count(plan.drop_landmark), 0);
  // What is not a keyframe does not stay as a pose; landmarks hosted there go with it.
  window.frames[0].is_keyframe = false;
  plan = PlanMarginalization(window, options);
  EXPECT_EQ(plan.drop_frame, std::vector<char>({1, 0, 0, 0}));
  EXPECT_EQ(Count(plan.drop_motion), 0);
  EXPECT_EQ(plan.drop_landmark, std::vector<char>({1}));
}

TEST(WindowPolicyTest, LandmarksLeaveWithTheirHostOrWhenLost) {
  WindowOptions options;
  options.max_full_keyframes = 2;
  options.max_pose_keyframes = 1;
  // Frame 1 shares least with the newest and goes.
  SlidingWindow window =
      WindowAt({0, 1, 2, 3}, {{0, 2, 3}, {0, 1, 2, 3}, {0, 2, 3}, {0, 1}, {1, 2}, {0, 2}});
  window.frames[0].has_motion = window.frames[1].has_motion = false;
  options.covisible_share = 0.5;
  const MarginalizationPlan plan = PlanMarginalization(window, options);
  EXPECT_EQ(plan.drop_frame, std::vector<char>({0, 1, 0, 0}));
  // Number 1 is hosted elsewhere and still seen; 3 is lost, 4 hosted there; 5 was never seen there.
  EXPECT_EQ(plan.drop_landmark, std::vector<char>({0, 0, 0, 1, 1, 0}));
}

// One more frame: it sees most of what the frame before saw, and five landmarks more.
void AddFrame(std::int64_t k, Rng& rng, SlidingWindow& window) {
  WindowFrame frame;
  frame.id = FrameId{k};
  frame.is_keyframe = rng.Uniform() < 0.8;
  frame.x.T_WB.p = 0.1 * static_cast<double>(k) * Vector3d::UnitX() + 0.05 * rng.Normal3();
  window.frames.push_back(frame);
  WindowObservation o;
  o.frame = window.newest_frame();
  for (WindowLandmark& landmark : window.landmarks()) {
    if (landmark.observations.back().frame == o.frame - 1 && rng.Uniform() < 0.8)
      landmark.observations.push_back(o);
  }
  for (std::int64_t l = 0; l < 5; ++l) {
    WindowLandmark& landmark = window.AddLandmark(LandmarkId{5 * k + l}, o.frame);
    landmark.has_depth = true;
    landmark.observations.push_back(o);
  }
}

TEST(WindowPolicyTest, SizesStayWithinLimitsOverALongRun) {
  WindowOptions options;
  options.max_full_keyframes = 4;
  options.max_pose_keyframes = 5;
  Rng rng(1);
  SlidingWindow window;
  for (std::int64_t k = 0; k < 300; ++k) {
    AddFrame(k, rng, window);
    int rounds = 0;
    while (true) {
      const MarginalizationPlan plan = PlanMarginalization(window, options);
      if (plan.IsEmpty()) break;
      ASSERT_LT(++rounds, 10);
      EXPECT_EQ(plan.drop_frame.back() + plan.drop_motion.back(), 0)
          << "the newest frame never leaves";
      // What Marginalize does to the window, without the arithmetic.
      window.RemoveLandmarks(plan.drop_landmark);
      for (int i = window.newest_frame(); i >= 0; --i) {
        if (plan.drop_motion[i]) window.RemoveMotion(i);
        if (plan.drop_frame[i]) window.RemoveFrame(i);
      }
    }
    int num_full = 0;
    for (const WindowFrame& f : window.frames)
      num_full += f.has_motion;
    EXPECT_LE(num_full, options.max_full_keyframes);
    EXPECT_LE(static_cast<int>(window.frames.size()) - num_full, options.max_pose_keyframes);
    EXPECT_LT(window.landmarks().size(), 200u);
  }
}

}  // namespace
}  // namespace facet
