// SPDX-License-Identifier: BSD-2-Clause
// Flights through a painted room, each with a world of its own.
#include "facet/loop/map_merge.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/loop/place_map.h"
#include "facet/testing/loop/painted_room.h"

namespace facet {
namespace {

using testing::LooksAhead;
using testing::PaintedRoom;
using testing::SmallCamera;
using testing::SmallRig;

constexpr int kPlacesPerLap = 24;

SE3 TruePose(double number, double radius_m) {
  const double angle = 2 * std::numbers::pi * number / kPlacesPerLap;
  return {ExpSO3(Vector3d(0, 0, angle)),
          Vector3d(radius_m * std::cos(angle), radius_m * std::sin(angle), 0.1)};
}

/// The map of a lap whose odometry has this world.
SavedMap MapOf(const PaintedRoom& room, const UprightPose& T_WM, double radius_m, double offset) {
  PlaceMap map(SmallRig(), LoopOptions());
  for (int i = 0; i < kPlacesPerLap; ++i) {
    const SE3 T_true = TruePose(i + offset, radius_m);
    map.Add(room.View(i, SmallCamera(), LooksAhead(), T_true, T_WM.ToSE3() * T_true));
  }
  return map.Saved();
}

const UprightPose kHere{0.3, Vector3d(1, 2, -0.5)}, kThere{2.5, Vector3d(7, -3, 0.5)};

/// How far a body of the run is from where it truly was, in the map, of which the first run's world
/// is the frame.
double Error_m(const SavedMap& map, int session, double radius_m, double offset) {
  double worst = 0;
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const MapKeyframe& keyframe = map.keyframes[i];
    if (keyframe.session != session) continue;
    const auto number = static_cast<double>(keyframe.frame.value);
    const Vector3d p_M = map.graph.nodes[i].T_MW * map.graph.nodes[i].p_W;
    worst = std::max(worst, (p_M - kHere * TruePose(number + offset, radius_m).p).norm());
  }
  return worst;
}

TEST(MapMergeTest, TheSecondMapIsFoundInTheFirst) {
  const PaintedRoom room(1);
  const SavedMap first = MapOf(room, kHere, 0.5, 0), second = MapOf(room, kThere, 0.6, 0.4);
  const MapMerge merge = MergeMaps(first, second);
  ASSERT_TRUE(merge.is_found);
  EXPECT_FALSE(merge.is_ambiguous);
  EXPECT_GE(merge.num_closures, 6);
  EXPECT_EQ(merge.map.num_sessions(), 2);
  EXPECT_EQ(merge.map.places.size(), first.places.size() + second.places.size());
  EXPECT_EQ(merge.map.graph.nodes.size(), first.graph.nodes.size() + second.graph.nodes.size());
  EXPECT_LT(Error_m(merge.map, 0, 0.5, 0), 0.01);
  EXPECT_LT(Error_m(merge.map, 1, 0.6, 0.4), 0.03);
  for (std::size_t i = first.keyframes.size(); i < merge.map.keyframes.size(); ++i)
    EXPECT_EQ(merge.map.keyframes[i].session, 1);
}

TEST(MapMergeTest, ALaterRunIsFoundInPlacesOfBoth) {
  const PaintedRoom room(1);
  MapMerge merge = MergeMaps(MapOf(room, kHere, 0.5, 0), MapOf(room, kThere, 0.6, 0.4));
  ASSERT_TRUE(merge.is_found);
  std::erase_if(merge.map.places, [](const PlaceRecord& place) { return place.session == 0; });
  PlaceMap run(SmallRig(), LoopOptions(), merge.map);
  const UprightPose elsewhere{-1, Vector3d(0, 9, 0)};
  for (int i = 0; i < 8; ++i) {
    const SE3 T_true = TruePose(3 * i + 0.7, 0.55);
    run.Add(room.View(i, SmallCamera(), LooksAhead(), T_true, elsewhere.ToSE3() * T_true));
  }
  ASSERT_TRUE(run.is_localised());
  const Vector3d p(0.3, 0.2, 0.1);
  EXPECT_LT((run.T_MW() * (elsewhere * p) - kHere * p).norm(), 0.04);
}

TEST(MapMergeTest, MapsOfOtherRoomsStayApart) {
  const MapMerge merge =
      MergeMaps(MapOf(PaintedRoom(1), kHere, 0.5, 0), MapOf(PaintedRoom(2), kThere, 0.5, 0));
  EXPECT_GT(merge.num_compared, 20);
  EXPECT_FALSE(merge.is_found);
  EXPECT_FALSE(merge.is_ambiguous);
  EXPECT_TRUE(merge.map.places.empty());
}

// The first map has the room twice, 20 m apart.
TEST(MapMergeTest, AMapThatLooksLikeTwoPartsOfTheOtherIsInNeither) {
  const PaintedRoom room(1);
  const MapMerge merge =
      MergeMaps(testing::Twice(MapOf(room, kHere, 0.5, 0)), MapOf(room, kThere, 0.6, 0.4));
  EXPECT_FALSE(merge.is_found);
  EXPECT_TRUE(merge.is_ambiguous);
}

}  // namespace
}  // namespace facet
