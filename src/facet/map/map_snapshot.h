// SPDX-License-Identifier: BSD-2-Clause
// Immutable copy of what the estimator knows, for the front end (depth), the mesher and output.
#pragma once

#include <vector>

#include "facet/geometry/plane.h"
#include "facet/imu/imu_types.h"

namespace facet {

struct LandmarkEstimate {
  LandmarkId id;
  Vector3d p_W = Vector3d::Zero();
  int num_observations = 0;
  double sigma_depth_m =
      0;  ///< 1-sigma of the distance from its cameras, their poses taken as known
};

struct KeyframePose {
  FrameId id;
  Timestamp t;
  SE3 T_WB;
};

struct PlaneEstimate {
  PlaneId id;
  Plane plane_W;
};

struct MapSnapshot {
  NavState latest;                      ///< newest frame
  std::vector<KeyframePose> keyframes;  ///< oldest first
  std::vector<PlaneEstimate> planes;
  std::vector<LandmarkEstimate> landmarks;  ///< sorted by id; every point in front of its cameras
};

}  // namespace facet
