// SPDX-License-Identifier: BSD-2-Clause
// Two laps through a painted room with an odometry that drifts.
#include "facet/loop/place_map.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/testing/loop/painted_room.h"

namespace facet {
namespace {

using testing::LooksAhead;
using testing::PaintedRoom;
using testing::SmallCamera;
using testing::SmallRig;

constexpr int kPerLap = 24;

SE3 TruePose(int number) {
  const double angle = 2 * std::numbers::pi * number / kPerLap;
  return {ExpSO3(Vector3d(0, 0, angle)),
          Vector3d(0.5 * std::cos(angle), 0.5 * std::sin(angle), 0.1)};
}

/// From the true world to the odometry's.
UprightPose Drift(int number) {
  return {2e-4 * number, 2e-3 * number * Vector3d(1, -0.5, 0.3)};
}

struct Flight {
  explicit Flight(const LoopOptions& options = {}) : map(SmallRig(), options) {}

  void Fly(const PaintedRoom& room, int first, int last) {
    for (int i = first; i < last; ++i) {
      map.Add(
          room.View(i, SmallCamera(), LooksAhead(), TruePose(i), Drift(i).ToSE3() * TruePose(i)));
    }
  }

  double ErrorInMap_m(int number) const {
    const SE3 T_MB = map.T_MW().ToSE3() * Drift(number).ToSE3() * TruePose(number);
    return (T_MB.p - TruePose(number).p).norm();
  }

  int NumAccepted() const {
    int num = 0;
    for (const ClosureRecord& closure : map.Closures())
      num += closure.verdict == kClosureAccepted ? 1 : 0;
    return num;
  }

  PlaceMap map;
};

TEST(PlaceMapTest, ASecondLapTakesTheDriftBack) {
  const PaintedRoom room(1);
  Flight flight;
  flight.Fly(room, 0, kPerLap);
  EXPECT_EQ(flight.NumAccepted(), 0);
  EXPECT_EQ(flight.map.T_MW().p.norm(), 0);
  flight.Fly(room, kPerLap, 2 * kPerLap);
  const int last = 2 * kPerLap - 1;
  EXPECT_GT(flight.NumAccepted(), 10);
  EXPECT_GT((Drift(last) * TruePose(last).p - TruePose(last).p).norm(), 0.1);
  // A lap later the map is as true as it was when the place was first seen.
  const double then_m = (Drift(last - kPerLap) * TruePose(last).p - TruePose(last).p).norm();
  EXPECT_LT(flight.ErrorInMap_m(last), then_m + 0.01);
  for (const ClosureRecord& closure : flight.map.Closures()) {
    if (closure.verdict != kClosureAccepted) continue;
    const auto place = static_cast<int>(closure.t_place.ns / 500'000'000);
    const auto query = static_cast<int>(closure.t.ns / 500'000'000);
    const UprightPose truth = Drift(place) * Drift(query).Inverse();
    const Vector3d p_W = Drift(query) * TruePose(query).p;
    EXPECT_LT((closure.T_WplaceWquery * p_W - truth * p_W).norm(), 0.015);
    EXPECT_LT(std::abs(closure.T_WplaceWquery.yaw_rad - truth.yaw_rad), 4e-3);
  }
}

TEST(PlaceMapTest, APlaceThatIsSeenAgainIsNotKeptTwice) {
  const PaintedRoom room(1);
  Flight flight;
  flight.Fly(room, 0, kPerLap);
  const int before = flight.map.num_places();
  EXPECT_GT(before, 8);
  flight.Fly(room, kPerLap, 3 * kPerLap);
  EXPECT_LE(flight.map.num_places(), before + 4);
}

TEST(PlaceMapTest, AnotherRoomOfTheSameShapeIsNotTakenForIt) {
  Flight flight;
  flight.Fly(PaintedRoom(1), 0, kPerLap);
  flight.Fly(PaintedRoom(2), kPerLap, 2 * kPerLap - 6);  // it sees nothing of its own again
  EXPECT_GT(flight.map.Closures().size(), 10U) << "it was looked for";
  EXPECT_EQ(flight.NumAccepted(), 0);
  EXPECT_EQ(flight.map.T_MW().p.norm(), 0);
}

TEST(PlaceMapTest, TheSameFlightGivesTheSameMap) {
  const PaintedRoom room(1);
  Flight one, two;
  one.Fly(room, 0, 30);
  two.Fly(room, 0, 30);
  EXPECT_EQ(one.map.T_MW().p, two.map.T_MW().p);
  EXPECT_EQ(one.map.T_MW().yaw_rad, two.map.T_MW().yaw_rad);
}

TEST(PlaceMapTest, SmoothedPosesOfUnknownFramesAreIgnored) {
  Flight flight;
  flight.map.Smooth(FrameId{5}, SE3());
  flight.Fly(PaintedRoom(1), 0, 3);
  flight.map.Smooth(FrameId{77}, SE3());
  EXPECT_EQ(flight.map.Corrections().size(), 2U) << "one keyframe a second";
}

// Also those that are older than one that has left the window already.
TEST(PlaceMapTest, WhatTheEstimatorLearnsMovesThePlacesInItsWindow) {
  constexpr double kUp_m = 0.5;
  const PaintedRoom room(1);
  Flight flight;
  MapSnapshot snapshot;
  for (int i = 0; i < kPerLap; ++i) {
    const KeyframeView view = room.View(i, SmallCamera(), LooksAhead(), TruePose(i), TruePose(i));
    flight.map.Add(view);
    SE3 learnt = TruePose(i);
    learnt.p.z() += kUp_m;
    snapshot.keyframes.push_back({view.frame, view.t, learnt});
  }
  snapshot.keyframes.pop_back();
  snapshot.keyframes.pop_back();
  flight.map.Refine(snapshot);
  snapshot.keyframes.erase(snapshot.keyframes.begin() + kPerLap / 2);
  flight.map.Refine(snapshot);
  for (int i = kPerLap; i < 2 * kPerLap; ++i)
    flight.map.Add(room.View(i, SmallCamera(), LooksAhead(), TruePose(i), TruePose(i)));
  int num_moved = 0;
  for (const ClosureRecord& closure : flight.map.Closures()) {
    const auto place = static_cast<int>(closure.t_place.ns / 500'000'000);
    const bool is_of_second_lap = closure.t.ns >= kPerLap * 500'000'000LL;
    if (!is_of_second_lap || closure.verdict != kClosureAccepted || place > kPerLap - 4) continue;
    EXPECT_NEAR(closure.T_WplaceWquery.p.z(), kUp_m, 0.02) << place;
    ++num_moved;
  }
  EXPECT_GT(num_moved, 5);
}

// An hour over a known place is not an hour of closures.
TEST(PlaceMapTest, HoveringOverAKnownPlaceCostsLittle) {
  const PaintedRoom room(1);
  Flight flight;
  flight.Fly(room, 0, kPerLap + 6);
  const std::size_t before = flight.map.Closures().size();
  for (int i = 0; i < 120; ++i) {  // a minute
    flight.map.Add(room.View(kPerLap + 6 + i,
                             SmallCamera(),
                             LooksAhead(),
                             TruePose(6),
                             Drift(kPerLap + 6).ToSE3() * TruePose(6)));
  }
  const std::size_t num_more = flight.map.Closures().size() - before;
  EXPECT_LE(num_more, 60U);
  EXPECT_GE(num_more, 10U) << "it is still looked at";
}

// ---- another run in the same room, whose world is turned and elsewhere

SavedMap MapOf(const PaintedRoom& room) {
  Flight flight;
  flight.Fly(room, 0, kPerLap);
  return flight.map.Saved();
}

struct LaterRun {
  explicit LaterRun(const SavedMap& known) : map(SmallRig(), LoopOptions(), known) {}

  void Fly(const PaintedRoom& room, int first, int last) {
    for (int i = first; i < last; ++i) {
      const SE3 T_true = TruePose(3 * i % kPerLap + 1);  // other places, in another order
      map.Add(room.View(i, SmallCamera(), LooksAhead(), T_true, T_WM.ToSE3() * T_true));
    }
  }

  double ErrorInMap_m() const {
    const Vector3d p_M(0.3, 0.2, 0.1);
    return (map.T_MW() * (T_WM * p_M) - p_M).norm();
  }

  UprightPose T_WM{2.5, Vector3d(7, -3, 0.5)};
  PlaceMap map;
};

TEST(PlaceMapTest, ALaterRunFindsItselfInTheMap) {
  const PaintedRoom room(1);
  LaterRun run(MapOf(room));
  EXPECT_FALSE(run.map.is_localised());
  run.Fly(room, 0, 6);
  ASSERT_TRUE(run.map.is_localised());
  EXPECT_LE(ToSeconds(*run.map.localised() - Timestamp{0}), 2.0);
  // The first lap has drifted by 5 cm itself.
  EXPECT_LT(run.ErrorInMap_m(), 0.06);
  EXPECT_NEAR(
      std::remainder(run.map.T_MW().yaw_rad + run.T_WM.yaw_rad, 2 * std::numbers::pi), 0, 0.01);
  run.Fly(room, 6, 12);
  EXPECT_LT(run.ErrorInMap_m(), 0.06);
  for (const MapCorrection& correction : run.map.Corrections())
    EXPECT_LT(
        (correction.T_MW * (run.T_WM * Vector3d(0.3, 0.2, 0.1)) - Vector3d(0.3, 0.2, 0.1)).norm(),
        0.06);
}

TEST(PlaceMapTest, ALaterRunInAnotherRoomIsNotFoundAndDoesNotSpoilTheMap) {
  const SavedMap known = MapOf(PaintedRoom(1));
  LaterRun run(known);
  run.Fly(PaintedRoom(2), 0, 20);
  EXPECT_FALSE(run.map.is_localised());
  EXPECT_FALSE(run.map.localised());
  EXPECT_FALSE(run.map.is_ambiguous());
  EXPECT_LT(run.map.T_MW().p.norm(), 0.1) << "its own laps are closed";
  const SavedMap saved = run.map.Saved();
  for (const PlaceRecord& place : saved.places)
    EXPECT_EQ(place.session, 0);
  EXPECT_EQ(saved.num_sessions(), known.num_sessions());
  EXPECT_EQ(saved.places.size(), known.places.size());
  EXPECT_EQ(saved.graph.nodes.size(), known.graph.nodes.size());
  EXPECT_EQ(saved.graph.edges.size(), known.graph.edges.size());
}

// Two rooms of the same paint: the views of the later run are the same in both.
TEST(PlaceMapTest, ARunThatLooksLikeTwoPlacesIsInNeither) {
  const PaintedRoom room(1);
  LaterRun run(testing::Twice(MapOf(room)));
  run.Fly(room, 0, 12);
  EXPECT_FALSE(run.map.is_localised());
  EXPECT_TRUE(run.map.is_ambiguous());
  for (const ClosureRecord& closure : run.map.Closures())
    EXPECT_NE(closure.verdict, kClosureAccepted);
}

TEST(PlaceMapTest, ARunThatWasFoundExtendsTheMap) {
  const PaintedRoom room(1);
  const SavedMap known = MapOf(room);
  LaterRun run(known);
  run.Fly(room, 0, 12);
  ASSERT_TRUE(run.map.is_localised());
  const SavedMap saved = run.map.Saved();
  EXPECT_EQ(saved.num_sessions(), 2);
  EXPECT_GT(saved.graph.nodes.size(), known.graph.nodes.size());
  LaterRun third(saved);
  third.T_WM = {-1, Vector3d(1, 2, 3)};
  third.Fly(room, 0, 6);
  EXPECT_TRUE(third.map.is_localised());
  EXPECT_LT(third.ErrorInMap_m(), 0.06);
}

/// A lens of 1.2 times the focal length.
CameraModel OtherCamera() {
  CameraIntrinsics k = SmallCamera().intrinsics();
  k.fx *= 1.2;
  k.fy *= 1.2;
  return CameraModel(k);
}

TEST(PlaceMapTest, ARunWithAnotherLensFindsItselfInTheMap) {
  const PaintedRoom room(1);
  StereoRig rig = SmallRig();
  rig.cameras = {OtherCamera(), OtherCamera()};
  PlaceMap map(rig, LoopOptions(), MapOf(room));
  const UprightPose T_WM{2.5, Vector3d(7, -3, 0.5)};
  for (int i = 0; i < 8; ++i) {
    const SE3 T_true = TruePose(3 * i % kPerLap + 1);
    map.Add(room.View(i, OtherCamera(), LooksAhead(), T_true, T_WM.ToSE3() * T_true));
  }
  ASSERT_TRUE(map.is_localised());
  const Vector3d p_M(0.3, 0.2, 0.1);
  EXPECT_LT((map.T_MW() * (T_WM * p_M) - p_M).norm(), 0.06);
  const SavedMap saved = map.Saved();
  ASSERT_EQ(saved.num_sessions(), 2);
  EXPECT_EQ(saved.lenses[0].fx, SmallCamera().intrinsics().fx);
  EXPECT_EQ(saved.lenses[1].fx, OtherCamera().intrinsics().fx);
}

// What the odometry claims after a loss may be far from true; its world goes on from there.
TEST(PlaceMapTest, AfterALossTheRunFindsItselfInItsOwnMap) {
  const PaintedRoom room(1);
  Flight flight;
  flight.Fly(room, 0, kPerLap);
  const UprightPose lost{1.2, Vector3d(2, -1, 0.3)};
  for (int i = kPerLap; i < kPerLap + 10; ++i) {
    KeyframeView view = room.View(
        i, SmallCamera(), LooksAhead(), TruePose(i), (lost * Drift(i)).ToSE3() * TruePose(i));
    view.segment = 1;
    view.sigma_p.setConstant(1);
    view.sigma_theta.setConstant(0.3);
    flight.map.Add(view);
  }
  const int last = kPerLap + 9;
  const SE3 T_MB = flight.map.T_MW().ToSE3() * (lost * Drift(last)).ToSE3() * TruePose(last);
  const double then_m = (Drift(last - kPerLap) * TruePose(last).p - TruePose(last).p).norm();
  EXPECT_LT((T_MB.p - TruePose(last).p).norm(), then_m + 0.02);
  EXPECT_TRUE(flight.map.is_localised());
  EXPECT_FALSE(flight.map.localised()) << "there was no map before";
}

// Its first part is in no map: that the second one looks like it says nothing.
TEST(PlaceMapTest, ALossBeforeTheRunIsFoundDoesNotMakeItFound) {
  const SavedMap known = MapOf(PaintedRoom(1));
  for (const std::uint64_t seed : {2, 1}) {
    LaterRun run(known);
    run.Fly(PaintedRoom(2), 0, 8);  // somewhere else
    for (int i = 8; i < 18; ++i) {
      const SE3 T_true = TruePose(3 * i % kPerLap + 1);
      const UprightPose lost{1.2, Vector3d(2, -1, 0.3)};
      KeyframeView view = PaintedRoom(seed).View(
          i, SmallCamera(), LooksAhead(), T_true, (lost * run.T_WM).ToSE3() * T_true);
      view.segment = 1;
      run.map.Add(view);
    }
    EXPECT_EQ(run.map.is_localised(), seed == 1);
    EXPECT_EQ(run.map.localised().has_value(), seed == 1);
    EXPECT_FALSE(run.map.is_ambiguous());
  }
}

// What it saw first is in the map, all that it should see then is not there.
TEST(PlaceMapTest, AFindingAfterWhichNothingIsAsExpectedIsTakenBack) {
  const SavedMap known = MapOf(PaintedRoom(1));
  LaterRun run(known);
  int next = 0;
  while (!run.map.is_localised() && next < 8) {
    run.Fly(PaintedRoom(1), next, next + 1);
    ++next;
  }
  ASSERT_TRUE(run.map.is_localised());
  run.Fly(PaintedRoom(2), next, next + 20);
  EXPECT_FALSE(run.map.is_localised());
  EXPECT_FALSE(run.map.localised());
  for (const ClosureRecord& closure : run.map.Closures()) {
    if (closure.verdict == kClosureAccepted) {
      EXPECT_GT(closure.t_place, Timestamp{next * 500'000'000LL - 1}) << "of its own";
    }
  }
  const SavedMap saved = run.map.Saved();
  EXPECT_EQ(saved.num_sessions(), 1);
  EXPECT_EQ(saved.places.size(), known.places.size());
  EXPECT_EQ(saved.graph.edges.size(), known.graph.edges.size());
  for (std::size_t i = 0; i < saved.graph.nodes.size(); ++i) {
    EXPECT_EQ(saved.graph.nodes[i].edge_to_previous, known.graph.nodes[i].edge_to_previous);
    EXPECT_LT((saved.graph.nodes[i].T_MW.p - known.graph.nodes[i].T_MW.p).norm(), 0.01);
  }
  // Back in the room it is found again.
  run.Fly(PaintedRoom(1), next + 20, next + 40);
  EXPECT_TRUE(run.map.is_localised());
  EXPECT_LT(run.ErrorInMap_m(), 0.06);
}

TEST(PlaceMapTest, ACameraThatStandsStillHasOneViewOnly) {
  const PaintedRoom room(1);
  LaterRun run(MapOf(room));
  const SE3 T_true = TruePose(5);
  for (int i = 0; i < 10; ++i)
    run.map.Add(room.View(i, SmallCamera(), LooksAhead(), T_true, run.T_WM.ToSE3() * T_true));
  int num_places = 0;
  std::optional<Timestamp> place;
  for (const ClosureRecord& closure : run.map.Closures()) {
    if (place != closure.t_place) ++num_places;
    place = closure.t_place;
  }
  EXPECT_GT(num_places, 0);
  EXPECT_TRUE(num_places > 1 || !run.map.is_localised());
}

TEST(PlaceMapTest, AnEmptyMapIsNone) {
  PlaceMap map(SmallRig(), LoopOptions(), SavedMap());
  EXPECT_TRUE(map.is_localised());
}

TEST(PlaceMapTest, KeyframesWithoutAnImageOrPointsAreNotKept) {
  Flight flight;
  KeyframeView view = PaintedRoom(1).View(0, SmallCamera(), LooksAhead(), SE3(), SE3());
  view.points.clear();
  flight.map.Add(view);
  view.left = cv::Mat();
  view.t = Timestamp{5'000'000'000};
  flight.map.Add(view);
  EXPECT_EQ(flight.map.num_places(), 0);
}

}  // namespace
}  // namespace facet
