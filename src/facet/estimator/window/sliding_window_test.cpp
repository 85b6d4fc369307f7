// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/sliding_window.h"

#include <map>
#include <set>

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

using testing::TestWindow;

TestWindow MakeWindow(std::uint64_t seed) {
  Rng rng(seed);
  testing::TestWindowOptions options;
  TestWindow test = testing::MakeTestWindow(options, rng);
  testing::Disturb(test.window, {}, rng);
  return test;
}

// Homogeneous point in the world, of unit length: also for points at infinity.
Vector4d HomogeneousPoint(const SlidingWindow& window, const WindowLandmark& landmark) {
  const SE3 T_WH = window.frames[landmark.host].x.T_WB * window.T_BC0;
  Vector4d point;
  point << T_WH.q * landmark.bearing_H + landmark.inverse_distance * T_WH.p,
      landmark.inverse_distance;
  return point.normalized();
}

void ExpectConsistent(SlidingWindow& window) {
  const int num_frames = static_cast<int>(window.frames.size());
  for (const WindowLandmark& landmark : window.landmarks()) {
    EXPECT_EQ(window.Find(landmark.id), &landmark);
    EXPECT_NEAR(landmark.bearing_H.norm(), 1, 1e-12);
    ASSERT_FALSE(landmark.observations.empty());
    bool seen_in_host = false;
    int last = -1;
    for (const WindowObservation& o : landmark.observations) {
      EXPECT_GT(o.frame, last);
      EXPECT_LT(o.frame, num_frames);
      last = o.frame;
      seen_in_host |= o.frame == landmark.host;
    }
    EXPECT_TRUE(seen_in_host);
  }
  for (int i = 0; i < num_frames; ++i)
    EXPECT_EQ(window.IndexOf(window.frames[i].id), i);
}

TEST(SlidingWindowTest, RehostingKeepsThePoint) {
  TestWindow test = MakeWindow(1);
  for (WindowLandmark& landmark : test.window.landmarks()) {
    for (const bool at_infinity : {false, true}) {
      if (at_infinity) landmark.inverse_distance = 0;
      const Vector4d before = HomogeneousPoint(test.window, landmark);
      for (const WindowObservation& o : std::vector<WindowObservation>(landmark.observations)) {
        test.window.Rehost(landmark, o.frame);
        EXPECT_EQ(landmark.host, o.frame);
        EXPECT_NEAR(landmark.bearing_H.norm(), 1, 1e-12);
        EXPECT_LT((HomogeneousPoint(test.window, landmark) - before).norm(), 1e-12);
      }
      EXPECT_EQ(landmark.inverse_distance == 0, at_infinity);
    }
  }
}

TEST(SlidingWindowTest, RemovingFramesKeepsEverythingElse) {
  for (std::uint64_t seed = 2; seed < 7; ++seed) {
    TestWindow test = MakeWindow(seed);
    SlidingWindow& window = test.window;
    Rng rng(seed);
    while (window.frames.size() > 1) {
      std::map<LandmarkId, Vector4d> points;
      std::map<LandmarkId, std::set<FrameId>> seen_in;
      for (const WindowLandmark& landmark : window.landmarks()) {
        points[landmark.id] = HomogeneousPoint(window, landmark);
        for (const auto& o : landmark.observations)
          seen_in[landmark.id].insert(window.frames[o.frame].id);
      }
      const int index = rng.Index(static_cast<int>(window.frames.size()));
      const FrameId gone = window.frames[index].id;
      window.RemoveFrame(index);
      ExpectConsistent(window);
      EXPECT_EQ(window.IndexOf(gone), -1);
      for (auto& [id, frames] : seen_in) {
        frames.erase(gone);
        const WindowLandmark* landmark = window.Find(id);
        ASSERT_EQ(landmark == nullptr, frames.empty());
        if (landmark == nullptr) continue;
        std::set<FrameId> now;
        for (const auto& o : landmark->observations)
          now.insert(window.frames[o.frame].id);
        EXPECT_EQ(now, frames);
        EXPECT_LT((HomogeneousPoint(window, *landmark) - points[id]).norm(), 1e-12);
      }
    }
  }
}

TEST(SlidingWindowTest, ALandmarkWithoutDepthTakesTheRayOfItsNewHost) {
  TestWindow test = MakeWindow(8);
  WindowLandmark& landmark = test.window.landmarks()[0];
  landmark.has_depth = false;
  const LandmarkId id = landmark.id;
  const Vector3d next = landmark.observations[1].rays[0].bearing;
  test.window.RemoveFrame(landmark.host);
  EXPECT_EQ(test.window.Find(id)->bearing_H, next);
}

TEST(SlidingWindowTest, AFrameInThePriorCannotBeRemoved) {
  TestWindow test = MakeWindow(9);
  test.window.prior.blocks = {MarginalPrior::Block::OfPose(FrameId{2}, 0)};
  EXPECT_THROW(test.window.RemoveFrame(2), CheckError);
  EXPECT_NO_THROW(test.window.RemoveFrame(3));
}

TEST(SlidingWindowTest, LandmarksAreFoundByIdAndExistOnce) {
  TestWindow test = MakeWindow(10);
  EXPECT_EQ(test.window.Find(LandmarkId{7}), nullptr);
  EXPECT_THROW(test.window.AddLandmark(test.window.landmarks()[3].id, 0), CheckError);
  std::vector<char> gone(test.window.landmarks().size(), 0);
  const LandmarkId first = test.window.landmarks()[0].id;
  for (std::size_t l = 0; l < gone.size(); l += 2)
    gone[l] = 1;
  const std::size_t left = gone.size() / 2;
  test.window.RemoveLandmarks(gone);
  EXPECT_EQ(test.window.landmarks().size(), left);
  EXPECT_EQ(test.window.Find(first), nullptr);
  ExpectConsistent(test.window);
  EXPECT_NO_THROW(test.window.AddLandmark(first, 0));
}

TEST(SlidingWindowTest, StepsOfFrozenVariablesGoIntoDelta) {
  Rng rng(11);
  WindowFrame frame;
  frame.x = frame.lin = testing::Retract({}, testing::RandomStep({0.5, 1, 1, 0.1, 0.1}, rng));
  WindowFrame frozen = frame;
  frozen.pose_frozen = frozen.motion_frozen = true;
  Vector<15> sum = Vector<15>::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vector<15> step = testing::RandomStep({0.01, 0.1, 0.1, 0.01, 0.01}, rng);
    sum += step;
    frozen.ApplyStep(step);
    frame.ApplyStep(step);
  }
  EXPECT_LT((frozen.delta - sum).norm(), 1e-14);
  EXPECT_LT((testing::Difference(frozen.lin, frozen.x) - sum).norm(), 1e-13);
  EXPECT_EQ(testing::Difference(frame.lin, frame.x).norm(), 0);
  EXPECT_EQ(frame.delta.norm(), 0);
}

TEST(SlidingWindowTest, ALinkGoesWithEitherOfItsFramesAndMotions) {
  TestWindow test = MakeWindow(12);
  const auto has_links = [&] {
    std::vector<bool> out;
    for (const WindowFrame& frame : test.window.frames)
      out.push_back(frame.imu_link.has_value());
    return out;
  };
  ASSERT_EQ(has_links(), std::vector<bool>({false, true, true, true, true, true}));
  test.window.RemoveMotion(4);
  EXPECT_FALSE(test.window.frames[4].has_motion);
  EXPECT_EQ(has_links(), std::vector<bool>({false, true, true, true, false, false}));
  test.window.RemoveFrame(1);
  EXPECT_EQ(has_links(), std::vector<bool>({false, false, true, false, false}));
}

TEST(SlidingWindowTest, AMotionInThePriorCannotBeRemoved) {
  TestWindow test = MakeWindow(13);
  test.window.prior.blocks = {MarginalPrior::Block::OfMotion(FrameId{2}, 0)};
  EXPECT_THROW(test.window.RemoveMotion(2), CheckError);
  EXPECT_NO_THROW(test.window.RemoveMotion(3));
}

TEST(SlidingWindowTest, LandmarksKnowTheirPlanesByIndex) {
  TestWindow test = MakeWindow(14);
  for (int k = 0; k < 3; ++k) {
    test.window.planes.emplace_back(
        PlaneId{10 + k}, Plane{}, Vector3d::Zero(), testing::kPlaneSigma_m);
  }
  PlaneLinks& links = test.window.landmarks()[0].planes;
  EXPECT_TRUE(links.Add(0) && links.Add(2) && links.Add(1));
  EXPECT_FALSE(links.Add(3)) << "there is no room for a fourth";
  test.window.landmarks()[1].planes.Add(1);
  EXPECT_EQ(test.window.CountPlaneLandmarks(), (std::vector<int>{1, 2, 1}));
  EXPECT_EQ(test.window.NumPlaneLandmarks(), 4);
  test.window.RemovePlane(1);
  EXPECT_EQ(std::vector<int>(links.begin(), links.end()), (std::vector<int>{0, 1}));
  EXPECT_EQ(test.window.landmarks()[1].planes.count(), 0);
  EXPECT_EQ(test.window.IndexOf(PlaneId{12}), 1);
}

TEST(SlidingWindowTest, RelationsHoldOnceAndBetweenKnownPlanesOnly) {
  using enum PlaneRelationKind;
  TestWindow test = MakeWindow(15);
  SlidingWindow& window = test.window;
  const PlaneId a{4}, b{7};
  for (const PlaneId plane : {a, b})
    window.planes.emplace_back(plane, Plane{}, Vector3d::Zero(), testing::kPlaneSigma_m);
  EXPECT_TRUE(window.AddRelation({kParallel, a, b}));
  EXPECT_FALSE(window.AddRelation({kParallel, a, b}));
  EXPECT_FALSE(window.AddRelation({kParallel, b, a}));
  EXPECT_FALSE(window.AddRelation({kParallel, a, a}));
  EXPECT_FALSE(window.AddRelation({kParallel, a, PlaneId{9}}));
  EXPECT_FALSE(window.AddRelation({kHorizontal, PlaneId{9}}));
  EXPECT_TRUE(window.AddRelation({kHorizontal, a}));
  EXPECT_FALSE(window.AddRelation({kHorizontal, a, b}));  // the second plane means nothing
  EXPECT_TRUE(window.AddRelation({kCoplanar, b, a}));
  EXPECT_EQ(window.relations.size(), 3u);
  window.RemovePlane(1);
  ASSERT_EQ(window.relations.size(), 1u);
  EXPECT_EQ(window.relations[0].relation.kind, kHorizontal);
  SlidingWindow empty;
  EXPECT_FALSE(empty.AddRelation({kHorizontal, a}));
}

}  // namespace
}  // namespace facet
