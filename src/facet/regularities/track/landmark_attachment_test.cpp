// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/landmark_attachment.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

TrackedPlane Plane3(int id) {
  PlaneCandidate candidate;
  candidate.plane_W = {Vector3d::UnitX(), 3};
  TrackedPlane known(candidate, Timestamp{0});
  if (id >= 0) known.Confirm(PlaneId{id}, Timestamp{});
  return known;
}

/// A fan of faces around landmark 0; its boundary are landmarks 1, 2, ... and, last, support
/// points.
class LandmarkAttachmentTest : public ::testing::Test {
 protected:
  LandmarkAttachmentTest() {
    for (int i = 0; i <= kBoundary; ++i) {
      map_.landmarks.emplace_back().id = LandmarkId{10 + i};
      landmark_of_point_.push_back(i);
    }
    landmark_of_point_.push_back(-1);  // a support point
    faces_.points.resize(landmark_of_point_.size());
    for (int i = 1; i < kBoundary; ++i)
      AddFace({0, i, i + 1});
  }

  void AddFace(const std::array<int, 3>& corners) {
    faces_.faces.emplace_back().corners = corners;
    plane_index_of_face_.push_back(-1);
  }

  std::vector<PlaneAttachment> Join() {
    PlaneAssignments out;
    AttachLandmarks(map_, faces_, landmark_of_point_, plane_index_of_face_, planes_, out);
    return out.attached;
  }

  static constexpr int kBoundary = 6;
  MapSnapshot map_;
  SurfaceFaces faces_;
  std::vector<int> landmark_of_point_, plane_index_of_face_;
  std::vector<TrackedPlane> planes_ = {Plane3(7)};
};

TEST_F(LandmarkAttachmentTest, TwoFacesOrHalfOfThemAreNeeded) {
  EXPECT_TRUE(Join().empty());
  plane_index_of_face_[0] = 0;  // landmarks 0, 1 and 2: one face of five, of one, of two
  std::vector<PlaneAttachment> joined = Join();
  ASSERT_EQ(joined.size(), 2u);
  EXPECT_EQ(joined[0].landmark, LandmarkId{11});
  EXPECT_EQ(joined[1].landmark, LandmarkId{12});
  EXPECT_EQ(joined[0].plane, PlaneId{7});
  plane_index_of_face_[1] = 0;  // now two of five
  joined = Join();
  ASSERT_EQ(joined.size(), 4u);
  EXPECT_EQ(joined[0].landmark, LandmarkId{10});
}

TEST_F(LandmarkAttachmentTest, LimitsAreLargerFarAway) {
  plane_index_of_face_[0] = 0;
  map_.landmarks[1].p_W = {0, 0, 0.5 * kFarDistance_m};
  map_.landmarks[2].p_W = {0, 0, 3 * kFarDistance_m};
  const std::vector<PlaneAttachment> joined = Join();
  ASSERT_EQ(joined.size(), 2u);
  EXPECT_EQ(joined[0].length_scale, 1);
  EXPECT_EQ(joined[1].length_scale, 3);
}

TEST_F(LandmarkAttachmentTest, WhoIsOnThePlaneOrOnOneThatBecameItDoesNotJoinAgain) {
  plane_index_of_face_[0] = 0;
  map_.landmarks[1].planes[0] = PlaneId{7};
  map_.landmarks[2].planes[1] = PlaneId{9};
  planes_[0].merged_ids = {PlaneId{9}};
  EXPECT_TRUE(Join().empty());
}

TEST_F(LandmarkAttachmentTest, ALandmarkMayJoinTwoPlanes) {
  planes_.push_back(Plane3(8));
  plane_index_of_face_ = {0, 0, 1, 1, -1};
  const std::vector<PlaneAttachment> joined = Join();
  const auto joins = [&](int landmark, int plane) {
    return std::any_of(joined.begin(), joined.end(), [&](const PlaneAttachment& join) {
      return join.landmark == LandmarkId{landmark} && join.plane == PlaneId{plane};
    });
  };
  EXPECT_TRUE(joins(10, 7) && joins(10, 8));
  EXPECT_TRUE(joins(13, 7) && joins(13, 8));
  EXPECT_FALSE(joins(11, 8));
}

TEST_F(LandmarkAttachmentTest, TentativePlanesAndSupportPointsHaveNoPart) {
  planes_[0] = Plane3(-1);
  plane_index_of_face_.assign(plane_index_of_face_.size(), 0);
  EXPECT_TRUE(Join().empty());
  planes_[0] = Plane3(7);
  plane_index_of_face_.assign(plane_index_of_face_.size(), -1);
  AddFace({kBoundary, kBoundary + 1, kBoundary + 1});
  plane_index_of_face_.back() = 0;
  const std::vector<PlaneAttachment> joined = Join();
  ASSERT_EQ(joined.size(), 1u);
  EXPECT_EQ(joined[0].landmark, LandmarkId{10 + kBoundary});
}

}  // namespace
}  // namespace facet
