// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/landmark_count.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

constexpr PlaneId kCountedWall{3}, kFloor{4};

std::vector<LandmarkEstimate> Landmarks(
    std::initializer_list<std::pair<int, std::vector<PlaneId>>> list) {
  std::vector<LandmarkEstimate> out;
  for (const auto& [id, planes] : list) {
    LandmarkEstimate& landmark = out.emplace_back();
    landmark.id = LandmarkId{id};
    std::copy(planes.begin(), planes.end(), landmark.planes.begin());
  }
  return out;
}

TEST(LandmarkCountTest, CountsEachLandmarkOnce) {
  LandmarkCount count;
  count.Update(
      Landmarks({{1, {kCountedWall}}, {2, {}}, {5, {kFloor, kCountedWall}}, {6, {kFloor}}}),
      kCountedWall);
  EXPECT_EQ(count.num(), 2);
  count.Update(Landmarks({{1, {}}, {2, {kCountedWall}}, {5, {kCountedWall}}, {6, {}}}),
               kCountedWall);
  EXPECT_EQ(count.num(), 3);
  count.Update(Landmarks({{1, {kCountedWall}}, {2, {kCountedWall}}, {6, {}}}),
               kCountedWall);  // 1 is back, 5 is gone
  EXPECT_EQ(count.num(), 3);
  count.Update(Landmarks({{7, {kCountedWall}}}), kCountedWall);
  EXPECT_EQ(count.num(), 4);
}

TEST(LandmarkCountTest, WhatLayOnBothPartsCountsOnce) {
  LandmarkCount wall, part;
  wall.Update(Landmarks({{1, {kCountedWall}}, {2, {kCountedWall}}}), kCountedWall);
  const auto landmarks = Landmarks({{2, {kFloor}}, {3, {kFloor}}});
  wall.Update(landmarks, kCountedWall);
  part.Update(landmarks, kFloor);
  wall.Add(part);
  EXPECT_EQ(wall.num(), 3);
  wall.Update(Landmarks({{2, {kCountedWall}}, {3, {kCountedWall}}}),
              kCountedWall);  // what was handed over is known
  EXPECT_EQ(wall.num(), 3);
}

}  // namespace
}  // namespace facet
