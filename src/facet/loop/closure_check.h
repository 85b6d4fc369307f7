// SPDX-License-Identifier: BSD-2-Clause
// Does a keyframe see a place of the map, and from where: matching of descriptors, consensus of
// upright poses, guided matching by projection, and a fit of the pose with its covariance.
#pragma once

#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "facet/camera/camera_model.h"
#include "facet/frontend/image_pyramid.h"
#include "facet/frontend/patch_tracker.h"
#include "facet/loop/place_record.h"
#include "facet/loop/upright_pose.h"

namespace facet {

/// A keyframe whose corners are described, to be looked for in the map.
struct PlaceQuery {
  CameraModel camera;  ///< left, by the present calibration
  SE3 T_WB, T_BC;
  double sigma_tilt_rad = 0;
  std::vector<UprightCorner> corners;
  /// Of two levels. Without it points are found where corners are described, not where their
  /// patches fit: fewer, and to half a pixel.
  const ImagePyramid* image = nullptr;

  SE3 T_WC() const { return T_WB * T_BC; }
};

/// What came of comparing a keyframe with a place.
struct ClosureCheck {
  std::string refusal;  ///< why it is not one; empty: it is
  int num_matches = 0;  ///< by descriptors alone
  int num_inliers = 0;  ///< after the guided matching
  int num_visible = 0;  ///< points of the place that should be seen
  /// From the odometry's world when the keyframe was taken to the one when the place was.
  UprightPose T_WplaceWquery;
  /// Of heading [rad] and the body's position in the place's world [m].
  Matrix4d covariance = Matrix4d::Zero();

  bool is_closure() const { return refusal.empty(); }
};

/// Where the keyframe may be, by what is known before: from its world to the place's, and how far
/// its points may lie from where that predicts them.
struct ClosurePrediction {
  UprightPose T_WplaceWquery;
  double max_angle_rad = std::numbers::pi;  ///< half a turn or more: anywhere
};

/// Keeps its buffers; not thread-safe. Deterministic.
class ClosureChecker {
 public:
  explicit ClosureChecker(int min_inliers) : min_inliers_(min_inliers) {}

  /// `places`: the place, then others of the same segment near it in time, which help.
  ClosureCheck Check(const PlaceQuery& query,
                     std::span<const PlaceRecord* const> places,
                     const ClosurePrediction& prediction);

 private:
  struct Point {
    Vector3d p_W = Vector3d::Zero();    // in the place's world
    Vector3d ray_W = Vector3d::Zero();  // unit, from the camera that saw it
    const RecordPoint* record = nullptr;
    const PlaceRecord* place = nullptr;
  };
  struct Match {
    int point = 0;
    Vector2d px = Vector2d::Zero();  // in the query's image
    double sigma_px = 0;
  };

  void ListPoints(std::span<const PlaceRecord* const> places);
  void MatchDescriptors(const PlaceQuery& query, const ClosurePrediction& prediction);
  /// Aligns the patches of all points where they should be seen; returns how many of the place
  /// itself should be.
  int AlignPatches(const PlaceQuery& query, const SE3& T_WC);
  /// The same without an image: the corners that look most like the points, near where those should
  /// be seen.
  int MatchNear(const PlaceQuery& query, const SE3& T_WC);
  /// Moves T_WC; keeps the matches that fit. False: the pose is not determined.
  bool Fit(const PlaceQuery& query, double sigma_tilt_rad, SE3& T_WB, Matrix<6, 6>& covariance);
  bool IsSpread(const PlaceQuery& query) const;

  int min_inliers_;
  std::size_t num_own_ = 0;  // the first of points_ are the place's own
  std::vector<Point> points_;
  std::vector<Match> matches_;
  std::vector<Vector3d> bearings_;  // of the corners, in the query's camera
  PatchTracker tracker_{KltOptions{}, 2};
  PatchPyramid patch_;
};

}  // namespace facet
