// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_evidence.h"

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/testing/estimator/plane_scene.h"

namespace facet {
namespace {

// One landmark on one plane, which leaves the window.
class PlaneEvidenceTest : public ::testing::Test {
 protected:
  PlaneEvidenceTest() : scene_(3) {
    PlaneAssignments join;
    join.created = {scene_.PlaneAt(1, 0.0)};
    join.attached = {{scene_.landmark, PlaneId{1}}};
    scene_.Apply(join);
  }
  SlidingWindow& window() { return scene_.window(); }
  WindowLandmark& landmark() { return window().landmarks()[0]; }
  double RowScale() const {
    return evidence_.RowScale(scene_.test.window, scene_.test.window.landmarks()[0], 0);
  }
  void Marginalize() {
    MarginalizationPlan plan(window());
    plan.drop_landmark[0] = 1;
    evidence_.UseUp(plan, window());
  }

  testing::PlaneScene scene_;
  PlaneEvidence evidence_;
};

TEST_F(PlaneEvidenceTest, TheFirstRowOfASpotCountsInFull) {
  EXPECT_EQ(RowScale(), 1);
  Marginalize();
  landmark().bearing_H = ExpSO3({0, 0.2, 0}) * landmark().bearing_H;
  EXPECT_EQ(RowScale(), 1) << "another spot";
}

TEST_F(PlaneEvidenceTest, WhatTheSameSpotSaysAgainCountsEverLess) {
  double information = 0;
  for (int k = 0; k < 1000; ++k) {
    const double scale = RowScale();
    EXPECT_EQ(scale, 2 * k + 1);
    information += 1 / (scale * scale);
    Marginalize();
  }
  EXPECT_LT(information, 1.24);
}

// The ray tells where on the plane it is, however uncertain the distance.
TEST_F(PlaneEvidenceTest, ALandmarkOfWrongDistanceIsTheSameSpot) {
  Marginalize();
  landmark().inverse_distance *= 1.02;
  EXPECT_EQ(RowScale(), 3);
}

TEST_F(PlaneEvidenceTest, WhatStaysInTheWindowIsNotUsedUp) {
  evidence_.UseUp(MarginalizationPlan(window()), window());
  EXPECT_EQ(RowScale(), 1);
}

TEST_F(PlaneEvidenceTest, ALandmarkThatComesBackJoinsWithARowThatCountsLess) {
  Marginalize();
  landmark().planes.Remove(0);
  PlaneAssignments join;
  join.attached = {{scene_.landmark, PlaneId{1}}};
  scene_.evidence = evidence_;
  scene_.Apply(join);
  ASSERT_EQ(landmark().planes.count(), 1);
  EXPECT_EQ(landmark().planes.row_scale(0), 3);
}

TEST_F(PlaneEvidenceTest, APlaneThatHasEndedIsForgotten) {
  Marginalize();
  window().RemovePlane(0);
  evidence_.UseUp(MarginalizationPlan(window()), window());
  PlaneAssignments join;
  join.created = {scene_.PlaneAt(1, 0.0)};
  scene_.Apply(join);
  EXPECT_EQ(RowScale(), 1);
}

}  // namespace
}  // namespace facet
