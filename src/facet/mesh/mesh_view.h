// SPDX-License-Identifier: BSD-2-Clause
// What the mesh is built from: the points that one keyframe sees, as plain data.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "facet/camera/camera_model.h"
#include "facet/geometry/se3.h"
#include "facet/map/map_snapshot.h"

namespace facet {

/// Ids from here on belong to support points: matched left to right in one keyframe, never tracked,
/// unknown to the estimator. They grow from view to view.
inline constexpr std::int64_t kFirstSupportId = std::int64_t{1} << 40;

inline bool IsSupport(LandmarkId id) {
  return id.value >= kFirstSupportId;
}

/// A point of the left image with a depth.
struct MeshPoint {
  LandmarkId id;
  Vector3d bearing = Vector3d::UnitZ();  ///< where it is seen: unit vector of the left camera
  Vector3d p_C = Vector3d::Zero();       ///< best estimate, in the left camera [m]
  double sigma_depth_m = 0;              ///< 1-sigma of the distance
  std::uint8_t intensity = 0;            ///< of the image there

  /// Whether the estimate has a distance along the bearing: numbers that are not finite have none,
  /// nor what lies behind the camera that sees it.
  bool IsInView() const {
    return p_C.allFinite() && bearing.dot(p_C) >= kMinDistance_m && std::isfinite(sigma_depth_m);
  }
};

/// One keyframe's points, in any order; each id at most once. Values that are not finite are
/// allowed and ignored.
struct MeshView {
  FrameId frame;
  Timestamp t;
  SE3 T_WC;               ///< left camera
  double focal_px = 0;    ///< for sizes in pixels
  double baseline_m = 0;  ///< of the stereo pair
  std::vector<MeshPoint> points;
  /// Ids of the support points that the keyframe has matched: from the first to before the end.
  LandmarkId first_match, end_match;
};

}  // namespace facet
