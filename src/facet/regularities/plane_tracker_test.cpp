// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/plane_tracker.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

using testing::BelievingEstimator;
using testing::MakeFloor;
using testing::MakeMesh;
using testing::MakeWall;
using testing::Patch;
using testing::TestView;

constexpr double kKeyframe_s = 0.2;

/// Runs keyframes through a tracker and an estimator that believes it.
class PlaneTrackerTest : public ::testing::Test {
 protected:
  PlaneTrackerTest() { floor_.first_id = 50000; }

  /// One keyframe that sees the patches.
  PlaneAssignments Step(const std::vector<Patch>& patches) {
    view_.time_s += kKeyframe_s;
    ++view_.seed;
    mesh_ = MakeMesh(patches, view_);
    RegularityResult found = tracker_.Process(mesh_, estimator_.Snapshot(mesh_));
    estimator_.Apply(found.assignments);
    num_created_ += static_cast<int>(found.assignments.created.size());
    face_plane_ids_ = std::move(found.mesh.face_plane_ids);
    return found.assignments;
  }
  void Run(const std::vector<Patch>& patches, int num_keyframes) {
    for (int k = 0; k < num_keyframes; ++k)
      Step(patches);
  }
  void UseOptions(const RegularityOptions& options) { tracker_ = PlaneTracker(options); }
  int NumPlaneLandmarks(PlaneId plane) const {
    int count = 0;
    for (const auto& [landmark, planes] : estimator_.memberships)
      count += static_cast<int>(std::count(planes.begin(), planes.end(), plane));
    return count;
  }

  TestView view_{{0, 0, 1.4}, 0.01, 1, 0, 1};
  SearchMesh mesh_;
  std::vector<int> face_plane_ids_;  // of mesh_
  BelievingEstimator estimator_;
  PlaneTracker tracker_{RegularityOptions()};
  int num_created_ = 0;
  const Patch wall_ = MakeWall({3, 0, 1.4}, 0, 3, 2);
  Patch floor_ = MakeFloor({2, 0, 0}, 2, 3);
};

TEST_F(PlaneTrackerTest, APlaneIsConfirmedAfterEnoughDetections) {
  const int needed = PlaneTrackingOptions().min_detections;
  for (int k = 1; k < needed; ++k) {
    EXPECT_TRUE(Step({wall_}).IsEmpty());
    EXPECT_TRUE(tracker_.Records().empty());
  }
  const PlaneAssignments found = Step({wall_});
  ASSERT_EQ(found.created.size(), 1u);
  EXPECT_EQ(found.created[0].id, PlaneId{0});
  EXPECT_GT(std::abs(found.created[0].plane_W.n.x()), 0.9995);
  EXPECT_NEAR(found.created[0].plane_W.SignedDistance(wall_.centre_W), 0, 0.02);
  EXPECT_LT((found.created[0].centroid_W - wall_.centre_W).norm(), 0.4);
  // All its landmarks come with it, and none twice.
  EXPECT_GT(found.attached.size(), 0.9 * static_cast<double>(mesh_.vertex_ids.size()));
  std::set<LandmarkId> landmarks;
  for (const PlaneAttachment& join : found.attached) {
    EXPECT_EQ(join.plane, PlaneId{0});
    EXPECT_TRUE(landmarks.insert(join.landmark).second);
  }
}

TEST_F(PlaneTrackerTest, APlaneWaitsUntilItsLandmarksDetermineItsNormal) {
  RegularityOptions options;
  options.tracking.max_normal_sigma_deg = 1.5;
  UseOptions(options);
  Patch board = MakeWall({3, 0, 1.4}, 0, 0.8, 0.8);
  board.step_m = 0.2;  // 25 landmarks, spread by 0.25 m
  view_.sigma_depth_m = 0.05;
  Run({board}, 10);  // to 0.05 / (5 * 0.25) rad = 2.3 deg
  EXPECT_EQ(num_created_, 0);
  view_.sigma_depth_m = 0.015;
  Run({board}, 3);
  EXPECT_EQ(num_created_, 1);
}

// Walls with hardly any texture have no more.
TEST_F(PlaneTrackerTest, FewLandmarksAreEnoughIfTheyAreFarApart) {
  // Of the wall's landmarks only `num` count, in a ring.
  const auto num_created = [&](int num, double radius_m, const RegularityOptions& options) {
    PlaneTracker tracker(options);
    int created = 0;
    for (int k = 0; k < 2 * PlaneTrackingOptions().min_detections; ++k) {
      view_.time_s += kKeyframe_s;
      ++view_.seed;
      const SearchMesh mesh = MakeMesh({wall_}, view_);
      MapSnapshot map = estimator_.Snapshot(mesh);
      std::vector<LandmarkEstimate> ring;
      for (int i = 0; i < num; ++i) {
        const double angle = 2 * std::numbers::pi * i / num;
        const Vector3d at_W =
            wall_.centre_W + radius_m * Vector3d(0, std::cos(angle), std::sin(angle));
        const auto nearest = std::min_element(
            map.landmarks.begin(), map.landmarks.end(), [&](const auto& a, const auto& b) {
              return (a.p_W - at_W).norm() < (b.p_W - at_W).norm();
            });
        ring.push_back(*nearest);
        map.landmarks.erase(nearest);
      }
      std::sort(ring.begin(), ring.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
      map.landmarks = ring;
      created += static_cast<int>(tracker.Process(mesh, map).assignments.created.size());
    }
    return created;
  };
  const int few = PlaneTrackingOptions().min_spread_landmarks;
  const int many = PlaneTrackingOptions().min_landmarks;
  ASSERT_LT(few, many);
  EXPECT_EQ(num_created(few - 1, 0.9, RegularityOptions()), 0);
  EXPECT_GT(num_created(few, 0.9, RegularityOptions()), 0);
  EXPECT_EQ(num_created(few, 0.3, RegularityOptions()), 0);
  EXPECT_GT(num_created(many, 0.3, RegularityOptions()), 0);
  RegularityOptions fewer;  // to be far apart is never a drawback
  fewer.tracking.min_landmarks = few - 1;
  EXPECT_GT(num_created(few - 1, 0.9, fewer), 0);
  RegularityOptions never;
  never.tracking.max_spread_sigma_deg = 0;
  EXPECT_EQ(num_created(many - 1, 0.9, never), 0);
  EXPECT_GT(num_created(many, 0.9, never), 0);
}

TEST_F(PlaneTrackerTest, TheSamePlaneIsNeverHandedOverTwice) {
  Run({wall_, floor_}, 30);
  EXPECT_EQ(num_created_, 2);
  ASSERT_EQ(tracker_.Records().size(), 2u);
  EXPECT_EQ(estimator_.planes.size(), 2u);
}

TEST_F(PlaneTrackerTest, FacesKnowTheirPlane) {
  Run({wall_, floor_}, 5);
  const std::vector<int>& planes = face_plane_ids_;
  ASSERT_EQ(planes.size(), mesh_.faces.size());
  int on_wall = 0, on_floor = 0;
  for (std::size_t f = 0; f < planes.size(); ++f) {
    if (planes[f] < 0) continue;
    const Plane& plane = estimator_.planes.at(PlaneId{planes[f]});
    const Vector3d& corner = mesh_.vertices[mesh_.faces[f][0]];
    EXPECT_NEAR(plane.SignedDistance(corner), 0, 0.08);
    (std::abs(plane.n.z()) > 0.5 ? on_floor : on_wall) += 1;
  }
  EXPECT_GT(on_wall + on_floor, 0.8 * static_cast<double>(planes.size()));
  EXPECT_GT(std::min(on_wall, on_floor), 50);
}

TEST_F(PlaneTrackerTest, RecordsTellWhatWasSeen) {
  Run({wall_, floor_}, 10);
  const std::vector<PlaneRecord> records = tracker_.Records();
  ASSERT_EQ(records.size(), 2u);
  for (const PlaneRecord& record : records) {
    const bool is_wall = record.orientation == PlaneOrientation::kVertical;
    EXPECT_EQ(record.label, is_wall ? PlaneLabel::kWall : PlaneLabel::kFloor);
    EXPECT_NEAR(record.area_m2, 6, 0.8);
    EXPECT_LT((record.centroid_W - (is_wall ? wall_ : floor_).centre_W).norm(), 0.1);
    EXPECT_NEAR(record.num_landmarks, NumPlaneLandmarks(record.id), 3) << "but for the newest";
    EXPECT_NEAR(ToSeconds(record.first_seen - Timestamp{0}), kKeyframe_s, 1e-9);
    EXPECT_EQ(record.last_seen, mesh_.t);
    EXPECT_GE(record.outline_W.size(), 4u);
    EXPECT_NEAR(record.sigma_normal_rad, estimator_.sigma_normal, 1e-9);
    EXPECT_GT(record.sigma_d_m, estimator_.sigma_offset_m);
  }
}

TEST_F(PlaneTrackerTest, AWallSeenPieceByPieceIsOnePlane) {
  // 10 m of wall pass by; every view shows 3 m of it and has landmarks of its own.
  for (double y = 0; y <= 7; y += 0.25) {
    view_.camera_W = {0, y, 1.4};
    Step({MakeWall({3, y, 1.4}, 0, 3, 2)});
  }
  EXPECT_EQ(num_created_, 1);
  ASSERT_EQ(tracker_.Records().size(), 1u);
  EXPECT_NEAR(tracker_.Records()[0].area_m2, 20, 2);
}

TEST_F(PlaneTrackerTest, AWallSeenFromBothEndsIsOnePlane) {
  Run({MakeWall({3, 0, 1.4}, 0, 3, 2)}, 5);
  view_.camera_W = {1, 3, 1.4};
  Run({MakeWall({3, 2.5, 1.4}, 0, 3, 2)}, 5);
  view_.camera_W = {2, -2, 0.8};
  Run({MakeWall({3, -1, 1.4}, 0, 3, 2)}, 5);
  EXPECT_EQ(num_created_, 1);
}

TEST_F(PlaneTrackerTest, WallsTenCentimetresApartStayTwo) {
  Run({MakeWall({3, 1.05, 1.4}, 0, 2, 2), MakeWall({3.1, -1.05, 1.4}, 0, 2, 2)}, 20);
  EXPECT_EQ(num_created_, 2);
  ASSERT_EQ(tracker_.Records().size(), 2u);
  for (const PlaneRecord& record : tracker_.Records()) {
    const double x = record.centroid_W.y() > 0 ? 3 : 3.1;
    EXPECT_NEAR(record.centroid_W.x(), x, 0.02);
  }
}

TEST_F(PlaneTrackerTest, AnUnseenPlaneSleepsAndIsRecognised) {
  Run({wall_}, 5);
  const Timestamp last_seen = mesh_.t;
  Run({floor_}, 40);
  ASSERT_EQ(num_created_, 2);
  EXPECT_EQ(tracker_.Records()[0].last_seen, last_seen);
  EXPECT_EQ(estimator_.planes.size(), 2u);
  // Back after 8 s: the pose is now known to 10 cm, and the wall appears 15 cm farther off.
  estimator_.sigma_p_m = 0.1;
  Patch displaced = wall_;
  displaced.centre_W.x() += 0.15;
  const PlaneAssignments found = Step({displaced});
  EXPECT_TRUE(found.created.empty());
  EXPECT_EQ(tracker_.Records()[0].last_seen, mesh_.t);
  EXPECT_GT(std::count(face_plane_ids_.begin(), face_plane_ids_.end(), 0), 100);
}

TEST_F(PlaneTrackerTest, LandmarksOfARecognisedPlaneMayBeAsFarOffAsItWas) {
  Run({wall_}, 5);
  Run({floor_}, 40);
  estimator_.sigma_p_m = 0.1;
  estimator_.memberships.clear();
  Patch displaced = wall_;
  displaced.centre_W.x() += 0.15;
  const PlaneAssignments found = Step({displaced});
  ASSERT_GT(found.attached.size(), 50u);
  for (const PlaneAttachment& join : found.attached) {
    if (join.plane == PlaneId{0}) {
      EXPECT_NEAR(join.max_distance_m, 0.3, 0.05);
    }
  }
}

TEST_F(PlaneTrackerTest, APlaneBeyondItsUncertaintyIsANewOne) {
  Run({wall_}, 5);
  Run({floor_}, 40);
  estimator_.sigma_p_m = 0.05;
  Patch displaced = wall_;
  displaced.centre_W.x() += 0.5;
  Run({displaced}, 5);
  EXPECT_EQ(num_created_, 3);
  EXPECT_LT(tracker_.Records()[0].last_seen, mesh_.t);
}

TEST_F(PlaneTrackerTest, PlanesEndAfterTheirTimeAndMayComeBackAsOthers) {
  RegularityOptions options;
  options.tracking.max_age_s = 6;
  UseOptions(options);
  std::vector<double> ended_s;
  double created_s = 0;
  for (int k = 0; k < 40; ++k) {
    const PlaneAssignments found = Step({wall_});
    if (created_s == 0 && !found.created.empty()) created_s = view_.time_s;
    for (const PlaneId id : found.retired) {
      EXPECT_EQ(id, PlaneId{0});
      ended_s.push_back(view_.time_s);
    }
  }
  ASSERT_EQ(ended_s.size(), 1u);
  EXPECT_NEAR(ended_s[0] - created_s, 6, 1e-6);
  EXPECT_EQ(num_created_, 2);
  const auto records = tracker_.Records();
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[1].id, PlaneId{1});
}

TEST_F(PlaneTrackerTest, WhatTheEstimatorDroppedGoesOnUnderItsNameWhenItIsSeenAgain) {
  Run({wall_}, 5);
  estimator_.planes.clear();
  estimator_.memberships.clear();
  const PlaneAssignments found = Step({floor_});
  EXPECT_TRUE(found.retired.empty());
  ASSERT_EQ(tracker_.Records().size(), 1u);
  EXPECT_EQ(tracker_.Records()[0].id, PlaneId{0});
  const Timestamp first_seen = tracker_.Records()[0].first_seen;
  Run({wall_}, 5);
  EXPECT_EQ(num_created_, 2);
  EXPECT_TRUE(estimator_.planes.contains(PlaneId{0}));
  ASSERT_EQ(tracker_.Records().size(), 1u);
  EXPECT_EQ(tracker_.Records()[0].first_seen, first_seen);
  EXPECT_EQ(tracker_.Records()[0].last_seen, mesh_.t);
}

TEST_F(PlaneTrackerTest, WhatItsSupportPointsMeasureIsHandedOver) {
  Run({wall_}, 5);
  view_.time_s += kKeyframe_s;
  mesh_ = MakeMesh({wall_}, view_);
  mesh_.end_match = LandmarkId{mesh_.vertex_ids.back().value + 1};  // all of them
  mesh_.first_match = mesh_.vertex_ids.front();
  MapSnapshot map = estimator_.Snapshot(mesh_);
  map.keyframes.push_back({FrameId{31}, mesh_.t, map.latest.T_WB});
  const PlaneAssignments found = tracker_.Process(mesh_, map).assignments;
  ASSERT_EQ(found.measurements.size(), 1u);
  EXPECT_EQ(found.measurements[0].plane, PlaneId{0});
  EXPECT_EQ(found.measurements[0].frame, FrameId{31});
  EXPECT_NEAR(
      wall_.ToPlane().SignedDistance(map.latest.T_WB * found.measurements[0].centre_B), 0, 0.01);
}

// Seen from one room, then from the other, then again, however badly the way between them is known.
TEST_F(PlaneTrackerTest, BothSidesOfAThinWallStayTwoPlanes) {
  const Patch near = MakeWall({3, 0, 1.4}, 0, 3, 2);
  Patch far = MakeWall({3.08, 0, 1.4}, std::numbers::pi, 3, 2);
  far.first_id = 20000;
  for (const double sigma_p_m : {0.003, 0.03, 0.1}) {
    tracker_ = PlaneTracker(RegularityOptions());
    estimator_ = BelievingEstimator();
    estimator_.sigma_p_m = sigma_p_m;
    num_created_ = 0;
    for (int round = 0; round < 3; ++round) {
      view_.camera_W = {0, 0, 1.4};
      Run({near}, 6);
      view_.camera_W = {6, 0, 1.4};
      Run({far}, 6);
      Run({floor_}, 10);
    }
    EXPECT_EQ(num_created_, 3) << sigma_p_m;
    for (const auto& [landmark, planes] : estimator_.memberships)
      EXPECT_LE(planes.size(), 1u) << sigma_p_m;
    for (const PlaneRecord& record : tracker_.Records())
      EXPECT_NEAR(record.area_m2, 6, 0.8) << sigma_p_m;
  }
}

// What the mesh still knows of the side that was left, 2 cm behind.
TEST_F(PlaneTrackerTest, OldFacesOfTheOtherSideDoNotCount) {
  Patch far = MakeWall({3.02, 0, 1.4}, std::numbers::pi, 3, 2);
  far.first_id = 20000;
  TestView behind = view_;
  behind.camera_W = {6, 0, 1.4};
  const SearchMesh old = MakeMesh({far}, behind);
  for (int k = 0; k < 6; ++k) {
    view_.time_s += kKeyframe_s;
    ++view_.seed;
    mesh_ = MakeMesh({wall_}, view_);
    const int first = static_cast<int>(mesh_.vertices.size());
    for (std::size_t i = 0; i < old.vertices.size(); ++i) {
      mesh_.vertices.push_back(old.vertices[i]);
      mesh_.vertex_ids.push_back(old.vertex_ids[i]);
      mesh_.sigma_depth_m.push_back(old.sigma_depth_m[i]);
    }
    for (const auto& face : old.faces) {
      mesh_.faces.push_back({face[0] + first, face[1] + first, face[2] + first});
      mesh_.may_vote.push_back(1);
      mesh_.in_view.push_back(0);
    }
    estimator_.Apply(tracker_.Process(mesh_, estimator_.Snapshot(mesh_)).assignments);
  }
  ASSERT_EQ(tracker_.Records().size(), 1u);
  EXPECT_GT(tracker_.Records()[0].num_landmarks, 50);
  for (const auto& [landmark, planes] : estimator_.memberships)
    EXPECT_TRUE(planes.empty() || landmark.value < far.first_id) << landmark.value;
}

TEST_F(PlaneTrackerTest, LandmarksThatTheEstimatorRefusesAreNotCounted) {
  for (int k = 0; k < 10; ++k) {
    Step({wall_});
    std::erase_if(estimator_.memberships,
                  [](const auto& member) { return member.first.value % 10 != 0; });
  }
  const std::vector<PlaneRecord> records = tracker_.Records();
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].num_landmarks, NumPlaneLandmarks(records[0].id));
  EXPECT_GT(records[0].num_landmarks, 5);
}

// A wall that is taken for upright while little of it is known turns out to lean.
TEST_F(PlaneTrackerTest, TheOrientationIsThatOfTheEstimate) {
  estimator_.sigma_normal = 0.0005;
  Run({wall_}, 5);
  ASSERT_EQ(tracker_.Records().size(), 1u);
  EXPECT_EQ(tracker_.Records()[0].orientation, PlaneOrientation::kVertical);
  Plane& known = estimator_.planes.begin()->second;
  const Vector3d n_W = ExpSO3({0, 3 * kDegree, 0}) * known.n;
  known = {n_W, n_W.dot(wall_.centre_W)};
  Step({floor_});
  EXPECT_EQ(tracker_.Records()[0].orientation, PlaneOrientation::kOblique);
}

TEST_F(PlaneTrackerTest, NoPlaneIsAssociatedWithADetectionWhoseNormalIsHardlyKnown) {
  tracker_ = PlaneTracker(
      RegularityOptions(), [](const SurfaceFaces& faces, const std::vector<char>& taken) {
        std::vector<PlaneCandidate> found = PlaneDetector(DetectionOptions()).Detect(faces, taken);
        for (PlaneCandidate& candidate : found)
          candidate.normal_covariance = 0.002 * Matrix3d::Identity();  // 4 deg
        return found;
      });
  Run({wall_}, 5);
  const Timestamp last_seen = mesh_.t;
  Run({floor_}, 40);
  Step({wall_});
  ASSERT_EQ(tracker_.Records().size(), 2u);
  EXPECT_EQ(tracker_.Records()[0].last_seen, last_seen);
}

TEST_F(PlaneTrackerTest, ResetForgetsAllAndNeverUsesAnIdAgain) {
  Run({wall_}, 5);
  tracker_.Reset();
  estimator_ = BelievingEstimator();
  EXPECT_EQ(tracker_.Records().size(), 1u);
  Run({wall_}, 5);
  ASSERT_EQ(tracker_.Records().size(), 2u);
  EXPECT_EQ(tracker_.Records()[1].id, PlaneId{1});
}

TEST_F(PlaneTrackerTest, ValuesComeFromTheEstimator) {
  Run({wall_}, 5);
  estimator_.planes[PlaneId{0}].d += 0.01;
  Step({wall_});
  EXPECT_EQ(tracker_.Records()[0].plane_W.d, estimator_.planes[PlaneId{0}].d);
}

TEST_F(PlaneTrackerTest, ATentativePlaneThatIsNotSeenAgainIsForgotten) {
  const int needed = PlaneTrackingOptions().min_detections;
  Run({wall_}, needed - 1);
  Run({}, 10);
  Run({wall_}, needed - 1);
  EXPECT_EQ(num_created_, 0);
  EXPECT_FALSE(Step({wall_}).created.empty());
}

TEST_F(PlaneTrackerTest, WithoutMeshOrLandmarksNothingHappens) {
  EXPECT_TRUE(Step({}).IsEmpty());
  EXPECT_TRUE(face_plane_ids_.empty());
  for (int k = 0; k < 6; ++k) {
    view_.time_s += kKeyframe_s;
    const SearchMesh mesh = MakeMesh({wall_}, view_);
    MapSnapshot map = estimator_.Snapshot(mesh);
    map.landmarks.clear();
    const RegularityResult found = tracker_.Process(mesh, map);
    EXPECT_TRUE(found.assignments.IsEmpty());
    face_plane_ids_ = found.mesh.face_plane_ids;
    EXPECT_EQ(std::count(face_plane_ids_.begin(), face_plane_ids_.end(), -1),
              static_cast<std::ptrdiff_t>(mesh.faces.size()));
  }
}

TEST_F(PlaneTrackerTest, LandmarksThatAreHardlyKnownMakeNoPlane) {
  view_.sigma_depth_m = 0.15;
  view_.pixel_noise = 0;
  Run({wall_}, 10);
  EXPECT_EQ(num_created_, 0);
}

TEST_F(PlaneTrackerTest, FacesThatAreNotFiniteBelongToNoPlane) {
  Run({floor_}, 5);
  view_.time_s += kKeyframe_s;
  mesh_ = MakeMesh({floor_}, view_);
  mesh_.vertices[0].setConstant(std::nan(""));
  mesh_.vertices[30].setConstant(1e300);
  face_plane_ids_ = tracker_.Process(mesh_, estimator_.Snapshot(mesh_)).mesh.face_plane_ids;
  for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
    const auto& corners = mesh_.faces[f];
    const bool is_bad = std::any_of(
        corners.begin(), corners.end(), [](int corner) { return corner == 0 || corner == 30; });
    if (is_bad) {
      EXPECT_EQ(face_plane_ids_[f], -1);
    }
  }
  EXPECT_TRUE(std::isfinite(tracker_.Records()[0].area_m2));
}

TEST_F(PlaneTrackerTest, PartsOfAWallThatMeetAreMerged) {
  // 4.5 m apart at first: two planes. Then the wall between them is seen.
  Run({MakeWall({3, -3, 1.4}, 0, 1.5, 2), MakeWall({3, 3, 1.4}, 0, 1.5, 2)}, 5);
  ASSERT_EQ(num_created_, 2);
  std::vector<PlaneId> ended;
  for (double y = -3; y <= 3; y += 0.25) {
    const PlaneAssignments found = Step({MakeWall({3, y, 1.4}, 0, 1.5, 2)});
    ended.insert(ended.end(), found.retired.begin(), found.retired.end());
  }
  EXPECT_EQ(ended, std::vector{PlaneId{1}});
  const auto records = tracker_.Records();
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].id, PlaneId{0});
  EXPECT_NEAR(records[0].area_m2, 15, 1.5);
  EXPECT_GT(NumPlaneLandmarks(PlaneId{0}), 50);
  EXPECT_EQ(NumPlaneLandmarks(PlaneId{1}), 0);
}

TEST_F(PlaneTrackerTest, APlaneThatDoesNotFitItsLandmarksEndsAndItsPartsAreFound) {
  const std::vector<Patch> parts = {MakeWall({3, 1.05, 1.4}, 0, 2, 2),
                                    MakeWall({3.2, -1.05, 1.4}, 0, 2, 2)};
  Run({MakeWall({3.1, 0, 1.4}, 0, 4, 2)}, 4);
  ASSERT_EQ(num_created_, 1);
  for (int k = 0; k < 2; ++k) {  // a wrong belief: all landmarks of both parts are on it
    for (int i = 0; i < 81; ++i)
      estimator_.memberships[LandmarkId{10000 * k + i}] = {PlaneId{0}};
  }
  std::vector<PlaneId> ended;
  for (int k = 0; k < 10; ++k) {
    const PlaneAssignments found = Step(parts);
    ended.insert(ended.end(), found.retired.begin(), found.retired.end());
  }
  EXPECT_EQ(ended, std::vector{PlaneId{0}});
  const auto records = tracker_.Records();
  ASSERT_EQ(records.size(), 2u);
  EXPECT_NEAR(std::abs(records[0].centroid_W.x() - records[1].centroid_W.x()), 0.2, 0.03);
}

TEST_F(PlaneTrackerTest, TwoRunsAreTheSame) {
  Run({wall_, floor_}, 12);
  const auto first = tracker_.Records();
  tracker_ = PlaneTracker(RegularityOptions());
  estimator_ = BelievingEstimator();
  view_.time_s = 0;
  view_.seed = 1;
  Run({wall_, floor_}, 12);
  const auto second = tracker_.Records();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    EXPECT_EQ(first[k].plane_W.d, second[k].plane_W.d);
    EXPECT_EQ(first[k].centroid_W, second[k].centroid_W);
    EXPECT_EQ(first[k].area_m2, second[k].area_m2);
  }
}

// Ceilings show few landmarks at a time.
TEST_F(PlaneTrackerTest, LandmarksOfEarlierViewsCountForANewPlane) {
  const auto num_created = [&](bool with_rest) {
    PlaneTracker tracker{RegularityOptions()};
    int created = 0;
    for (int k = 0; k < 2 * PlaneTrackingOptions().min_detections; ++k) {
      view_.time_s += kKeyframe_s;
      ++view_.seed;
      SearchMesh mesh = MakeMesh({wall_}, view_);
      MapSnapshot map = estimator_.Snapshot(mesh);
      int in_view = 0;  // landmarks on the half that is in view, less than a new plane needs
      std::erase_if(map.landmarks, [&](const LandmarkEstimate& landmark) {
        const bool is_old = landmark.p_W.y() < 0;
        return is_old ? !with_rest : ++in_view >= PlaneTrackingOptions().min_spread_landmarks;
      });
      for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        for (const int corner : mesh.faces[f])
          mesh.in_view[f] = mesh.in_view[f] != 0 && mesh.vertices[corner].y() >= 0 ? 1 : 0;
      }
      created += static_cast<int>(tracker.Process(mesh, map).assignments.created.size());
    }
    return created;
  };
  EXPECT_EQ(num_created(false), 0);
  EXPECT_GT(num_created(true), 0);
}

}  // namespace
}  // namespace facet
