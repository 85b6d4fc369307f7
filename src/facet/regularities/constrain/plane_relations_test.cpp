// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/constrain/plane_relations.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr int kMinKeyframes = 5;  // in which a relation must hold

/// A handful of planes, all persistent and known to 0.3 deg.
class PlaneRelationsTest : public ::testing::Test {
 protected:
  void AddPlane(const Vector3d& n_W, PlaneOrientation orientation, double area_m2 = 5) {
    PlaneEstimate estimate;
    estimate.id = PlaneId{static_cast<std::int64_t>(estimates_.size())};
    estimate.plane_W.n = n_W.normalized();
    estimate.is_persistent = true;
    const Matrix<3, 2> basis = TangentBasis(estimate.plane_W.n);
    estimate.covariance.block<3, 3>(6, 6) =
        std::pow(0.3 * kDegree, 2) * (basis * basis.transpose());
    estimates_.push_back(estimate);
    orientations_.push_back(orientation);
    areas_.push_back(area_m2);
    centroids_.push_back(Vector3d::Zero());
  }
  void AddTable(double height_m, double area_m2 = 5) {
    AddPlane(Vector3d::UnitZ(), PlaneOrientation::kHorizontal, area_m2);
    estimates_.back().covariance(9, 9) = std::pow(0.005, 2);
    centroids_.back().z() = height_m;
  }
  void AddWall(double azimuth_deg, double lean_deg = 0, double area_m2 = 5) {
    const double azimuth = azimuth_deg * kDegree, lean = lean_deg * kDegree;
    AddPlane(
        {std::cos(azimuth) * std::cos(lean), std::sin(azimuth) * std::cos(lean), std::sin(lean)},
        PlaneOrientation::kVertical,
        area_m2);
  }
  std::vector<PlaneRelation> Update(int num_keyframes) {
    std::vector<PlaneRelation> out;
    for (int k = 0; k < num_keyframes; ++k) {
      std::vector<RelatedPlane> planes;
      for (std::size_t i = 0; i < estimates_.size(); ++i)
        planes.push_back({&estimates_[i], orientations_[i], areas_[i], centroids_[i]});
      relations_.Update(planes, out);
    }
    return out;
  }
  static bool Contains(const std::vector<PlaneRelation>& list, const PlaneRelation& relation) {
    return std::any_of(list.begin(), list.end(), [&](const PlaneRelation& other) {
      return other.Canonical() == relation.Canonical();
    });
  }

  std::vector<PlaneEstimate> estimates_;
  std::vector<PlaneOrientation> orientations_;
  std::vector<double> areas_;
  std::vector<Vector3d> centroids_;
  PlaneRelationOptions options_;
  PlaneRelations relations_{PlaneRelationOptions()};
};

TEST_F(PlaneRelationsTest, ARoomsWallsAreRelatedToOneOfThem) {
  for (const double azimuth : {20.0, 110.5, 200.2, -70.4})
    AddWall(azimuth, 0.2);
  AddPlane({0.003, 0, 1}, PlaneOrientation::kHorizontal);
  const auto found = Update(kMinKeyframes);
  using enum PlaneRelationKind;
  EXPECT_TRUE(Contains(found, {kHeadingOrthogonal, PlaneId{0}, PlaneId{1}}));
  EXPECT_TRUE(Contains(found, {kHeadingParallel, PlaneId{0}, PlaneId{2}}));
  EXPECT_TRUE(Contains(found, {kHeadingOrthogonal, PlaneId{0}, PlaneId{3}}));
  for (int wall = 0; wall < 4; ++wall)
    EXPECT_TRUE(Contains(found, {kVertical, PlaneId{wall}})) << wall;
  EXPECT_TRUE(Contains(found, {kHorizontal, PlaneId{4}}));
  // A star: the three relations of headings and the five to gravity are all.
  EXPECT_EQ(found.size(), 8u);
}

TEST_F(PlaneRelationsTest, EachRelationIsProposedOnceAndOnlyWhenItHasHeldForAWhile) {
  AddWall(0);
  AddWall(90);
  EXPECT_TRUE(Update(kMinKeyframes - 1).empty());
  EXPECT_EQ(Update(1).size(), 3u);
  EXPECT_TRUE(Update(20).empty());
}

TEST_F(PlaneRelationsTest, AnInterruptionStartsTheCountAnew) {
  AddWall(0);
  Update(kMinKeyframes - 1);
  estimates_[0].plane_W.n = Vector3d(std::cos(0.1), 0, std::sin(0.1));
  EXPECT_TRUE(Update(1).empty());
  estimates_[0].plane_W.n = Vector3d::UnitX();
  EXPECT_TRUE(Update(kMinKeyframes - 1).empty());
  EXPECT_EQ(Update(1).size(), 1u);
}

TEST_F(PlaneRelationsTest, AWallAtAnotherAngleHasAHeadingOfItsOwn) {
  AddWall(0);
  AddWall(30);
  AddWall(121);
  const auto found = Update(kMinKeyframes);
  using enum PlaneRelationKind;
  EXPECT_TRUE(Contains(found, {kHeadingOrthogonal, PlaneId{1}, PlaneId{2}}));
  EXPECT_EQ(found.size(), 4u) << "three walls upright, one pair";
}

TEST_F(PlaneRelationsTest, WhatIsOffOrSmallOrObliqueIsNotRelated) {
  AddWall(0);
  AddWall(95);          // 5 deg off: neither related nor a heading of its own
  AddWall(90, 0, 0.5);  // small: upright only
  AddWall(180, 9);      // leans
  AddPlane({0.5, 0, 0.8}, PlaneOrientation::kOblique);
  estimates_.push_back(estimates_[0]);  // not persistent
  estimates_.back().id = PlaneId{5};
  estimates_.back().is_persistent = false;
  orientations_.push_back(PlaneOrientation::kVertical);
  areas_.push_back(5);
  centroids_.push_back(Vector3d::Zero());
  const auto found = Update(50);
  for (const PlaneRelation& relation : found) {
    EXPECT_FALSE(relation.Involves(PlaneId{4}));
    EXPECT_FALSE(relation.Involves(PlaneId{5}));
  }
  using enum PlaneRelationKind;
  EXPECT_FALSE(Contains(found, {kHeadingOrthogonal, PlaneId{0}, PlaneId{1}}));
  EXPECT_FALSE(Contains(found, {kHeadingOrthogonal, PlaneId{0}, PlaneId{2}}));
  EXPECT_FALSE(Contains(found, {kVertical, PlaneId{3}}));
}

// At the start it may be the estimate that leans; the estimator would give the relation up.
TEST_F(PlaneRelationsTest, WhatLeansIsRelatedToGravityOnceItDoesNotAnyMore) {
  AddWall(0, 1.5);
  EXPECT_TRUE(Update(50).empty());
  const Vector3d upright = Vector3d::UnitX();
  estimates_[0].plane_W.n = upright;
  const auto found = Update(kMinKeyframes);
  EXPECT_EQ(found.size(), 1u);
  EXPECT_TRUE(Contains(found, {PlaneRelationKind::kVertical, PlaneId{0}}));
}

TEST_F(PlaneRelationsTest, TheLargestIsInTheMiddle) {
  AddWall(0, 0, 1.1);
  AddWall(90, 0, 30);
  AddWall(180, 0, 4);
  const auto found = Update(kMinKeyframes);
  using enum PlaneRelationKind;
  EXPECT_TRUE(Contains(found, {kHeadingOrthogonal, PlaneId{1}, PlaneId{0}}));
  EXPECT_TRUE(Contains(found, {kHeadingOrthogonal, PlaneId{1}, PlaneId{2}}));
  EXPECT_EQ(found.size(), 5u);
}

TEST_F(PlaneRelationsTest, LevelPlanesHaveOneHeight) {
  AddTable(0.70, 2);
  AddTable(0.71, 3);
  AddTable(0.685, 1.5);  // has a height of its own
  AddTable(0.735, 2);    // and this one
  AddTable(0.74, 1.8);
  AddTable(0.705, 0.5);  // too small
  AddTable(0, 9);
  AddTable(0.72, 3);  // known too well to be at 0.71
  estimates_.back().covariance(9, 9) = std::pow(0.001, 2);
  estimates_[1].covariance(9, 9) = std::pow(0.001, 2);
  AddTable(0.705, 2);  // the underside
  estimates_.back().plane_W.n = -Vector3d::UnitZ();
  const auto found = Update(50);
  using enum PlaneRelationKind;
  const auto num_coplanar = std::count_if(
      found.begin(), found.end(), [](const auto& relation) { return relation.kind == kCoplanar; });
  EXPECT_EQ(num_coplanar, 2);
  EXPECT_TRUE(Contains(found, {kCoplanar, PlaneId{0}, PlaneId{1}}));
  EXPECT_TRUE(Contains(found, {kCoplanar, PlaneId{3}, PlaneId{4}}));
  options_.same_height = false;
  relations_ = PlaneRelations(options_);
  EXPECT_EQ(Update(50).size(), found.size() - 2);
}

TEST_F(PlaneRelationsTest, AMiddleThatTurnsOutToLeanIsNone) {
  AddWall(0, 0, 9);
  Update(kMinKeyframes);
  orientations_[0] = PlaneOrientation::kOblique;
  AddWall(90);
  for (const PlaneRelation& relation : Update(2 * kMinKeyframes))
    EXPECT_FALSE(relation.Involves(PlaneId{0}));
}

// The sides of a roof are at right angles to each other or parallel over the ridge beyond.
TEST_F(PlaneRelationsTest, SlopesAreRelatedWhenAskedFor) {
  using enum PlaneRelationKind;
  AddPlane({1, 0, 1}, PlaneOrientation::kOblique, 20);
  AddPlane({-1, 0, 1.01}, PlaneOrientation::kOblique, 19);
  AddPlane({1, 0.01, 1}, PlaneOrientation::kOblique, 18);
  AddPlane({0, 1, 1}, PlaneOrientation::kOblique, 17);  // 60 deg
  EXPECT_TRUE(Update(50).empty());
  options_.slopes = true;
  relations_ = PlaneRelations(options_);
  const auto found = Update(kMinKeyframes);
  EXPECT_EQ(found.size(), 2u);
  EXPECT_TRUE(Contains(found, {kOrthogonal, PlaneId{0}, PlaneId{1}}));
  EXPECT_TRUE(Contains(found, {kParallel, PlaneId{0}, PlaneId{2}}));
}

TEST_F(PlaneRelationsTest, SwitchedOffNothingIsRelated) {
  options_.enabled = false;
  relations_ = PlaneRelations(options_);
  AddWall(0);
  AddWall(90);
  EXPECT_TRUE(Update(20).empty());
}

// The estimator dropped a plane and its relations; later it is seen again under its name.
TEST_F(PlaneRelationsTest, WhatIsForgottenMayBeProposedAgain) {
  AddWall(20);
  AddWall(110);
  const auto first = Update(2 * kMinKeyframes);
  EXPECT_TRUE(Update(2 * kMinKeyframes).empty());
  relations_.Forget(PlaneId{1});
  const auto again = Update(2 * kMinKeyframes);
  EXPECT_EQ(first.size(), 3u);  // both upright, and at right angles
  EXPECT_EQ(again.size(), 2u);
  EXPECT_TRUE(Contains(again, {PlaneRelationKind::kVertical, PlaneId{1}}));
  EXPECT_FALSE(Contains(again, {PlaneRelationKind::kVertical, PlaneId{0}}));
}

}  // namespace
}  // namespace facet
