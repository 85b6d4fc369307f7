// SPDX-License-Identifier: BSD-2-Clause
// What is kept of a keyframe so that it is recognised later, and what a keyframe brings to be
// recognised.
#pragma once

#include <array>
#include <deque>
#include <memory>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/camera/camera_model.h"
#include "facet/geometry/se3.h"
#include "facet/loop/upright_corners.h"

namespace facet {

/// A point of a keyframe with its depth.
struct PlacePoint {
  LandmarkId landmark;              ///< of the estimator
  Vector2d px = Vector2d::Zero();   ///< in the left image
  Vector3d p_C = Vector3d::Zero();  ///< in the left camera [m]
  double sigma_depth_m = 0;         ///< 1-sigma of the distance
};

/// A keyframe of the odometry as the map of places needs it.
struct KeyframeView {
  FrameId frame;
  Timestamp t;
  int segment = 0;
  CameraModel camera;  ///< left, by the present calibration
  SE3 T_WB;            ///< causal, of the odometry
  SE3 T_BC;            ///< left camera
  /// Theta in B [rad] and p in W [m], as the estimator believes it.
  Vector3d sigma_theta = Vector3d::Zero(), sigma_p = Vector3d::Zero();
  cv::Mat left;  ///< 8 bit grey
  std::vector<PlacePoint> points;
};

/// The grey values around a point on one level of the image pyramid.
struct RecordPatch {
  static constexpr int kSide = 13;  ///< what PatchTracker reads around a point
  std::array<std::uint8_t, kSide * kSide> grey{};
  float x = 0, y = 0;  ///< of the point in it
};

/// A point as it is kept.
struct RecordPoint {
  Eigen::Vector3f p_C = Eigen::Vector3f::Zero();  ///< [m]
  Eigen::Vector2f px = Eigen::Vector2f::Zero();
  float sigma_depth_m = 0;
  std::array<RecordPatch, 2> patches;  ///< levels 0 and 1
  std::array<BinaryDescriptor, kNumCornerLevels> descriptors{};
};

/// About 480 bytes per point.
struct PlaceRecord {
  int node = -1;  ///< of the pose graph
  Timestamp t;
  int segment = 0;
  int session = 0;  ///< runs before this one have lower numbers
  FrameId frame;
  SE3 T_WB;  ///< of the odometry, as it was last estimated while in the window
  SE3 T_BC;
  double sigma_tilt_rad = 0;
  double median_distance_m = 1;  ///< of its points
  /// Of runs before: their left camera. Otherwise the present one.
  std::shared_ptr<const CameraModel> lens;
  std::vector<RecordPoint> points;
  std::vector<LandmarkId> landmarks;  ///< of the points, while the keyframe is in the window

  SE3 T_WC() const { return T_WB * T_BC; }
};

/// Gives each place the lens of its session; sessions without one have the present one.
void SetLenses(const std::vector<CameraIntrinsics>& lenses, std::deque<PlaceRecord>& places);

/// A place and those just before and after it in the same flight, which see much of the same; the
/// place first. Places of a session and segment are in order of time.
std::vector<const PlaceRecord*> WithNeighbours(const std::deque<PlaceRecord>& places, int place);

}  // namespace facet
