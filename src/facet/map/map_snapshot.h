// SPDX-License-Identifier: BSD-2-Clause
// Immutable copy of what the estimator knows, for the front end (depth), the mesher and output.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/geometry/plane.h"
#include "facet/imu/imu_types.h"
#include "facet/map/plane_relation.h"

namespace facet {

struct LandmarkEstimate {
  LandmarkId id;
  Vector3d p_W = Vector3d::Zero();
  int num_observations = 0;
  double sigma_depth_m =
      0;  ///< 1-sigma of the distance from its cameras, their poses taken as known
  std::array<PlaneId, 3> planes{};  ///< the planes it lies on; the rest is invalid

  bool IsOn(PlaneId plane) const {
    return planes[0] == plane || planes[1] == plane || planes[2] == plane;
  }
};

struct KeyframePose {
  FrameId id;
  Timestamp t;
  SE3 T_WB;
};

struct PlaneEstimate {
  PlaneId id;
  Plane plane_W;
  Vector3d anchor_W = Vector3d::Zero();  ///< a point near its landmarks
  int num_landmarks = 0;                 ///< that lie on it, in the window
  double row_sigma_m = 0.02;             ///< 1-sigma of the rows that hold landmarks on it
  bool is_persistent = false;            ///< known well enough to stay for the whole run
  /// Joint with the newest keyframe's pose: theta and p of the pose, then how the normal moves
  /// [rad, along the axes of W] and n . (p - anchor) [m]. Zero until the plane was solved for.
  Matrix<10, 10> covariance = Matrix<10, 10>::Zero();
};

struct MapSnapshot {
  NavState latest;  ///< newest frame
  SE3 T_WC0;        ///< left camera when the newest frame's image was taken
  /// The calibration at present; null: the one that was given.
  std::shared_ptr<const StereoRig> rig;
  std::vector<KeyframePose> keyframes;  ///< oldest first
  std::vector<PlaneEstimate> planes;
  std::vector<PlaneRelation> relations;     ///< between these planes, in force
  std::vector<LandmarkEstimate> landmarks;  ///< sorted by id; every point in front of its cameras
};

/// Null if the snapshot does not hold it.
inline const LandmarkEstimate* FindLandmark(const MapSnapshot& snapshot, LandmarkId id) {
  const auto found = std::lower_bound(
      snapshot.landmarks.begin(),
      snapshot.landmarks.end(),
      id,
      [](const LandmarkEstimate& landmark, LandmarkId sought) { return landmark.id < sought; });
  return found != snapshot.landmarks.end() && found->id == id ? &*found : nullptr;
}

}  // namespace facet
