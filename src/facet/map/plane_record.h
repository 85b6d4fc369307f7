// SPDX-License-Identifier: BSD-2-Clause
// What users are told about a plane.
#pragma once

#include <vector>

#include "facet/geometry/plane.h"

namespace facet {

enum class PlaneOrientation { kHorizontal, kVertical, kOblique };
enum class PlaneLabel { kFloor, kTable, kCeiling, kWall, kOther };

struct PlaneRecord {
  PlaneId id;
  Plane plane_W;
  Vector3d centroid_W = Vector3d::Zero();  ///< of the surface seen
  PlaneOrientation orientation = PlaneOrientation::kOblique;
  PlaneLabel label = PlaneLabel::kOther;
  Timestamp first_seen, last_seen;
  int num_landmarks = 0;  ///< that ever lay on it
  double area_m2 = 0;     ///< of the surface seen
  double sigma_normal_rad = 0, sigma_d_m = 0;
  std::vector<PlaneId> merged_ids;  ///< planes that turned out to be the same surface
  std::vector<Vector3d> outline_W;  ///< convex, counter-clockwise seen from where the normal points
};

inline const char* ToString(PlaneOrientation orientation) {
  switch (orientation) {
    case PlaneOrientation::kHorizontal:
      return "horizontal";
    case PlaneOrientation::kVertical:
      return "vertical";
    case PlaneOrientation::kOblique:
      return "oblique";
  }
  return "";
}

inline const char* ToString(PlaneLabel label) {
  switch (label) {
    case PlaneLabel::kFloor:
      return "floor";
    case PlaneLabel::kTable:
      return "table";
    case PlaneLabel::kCeiling:
      return "ceiling";
    case PlaneLabel::kWall:
      return "wall";
    case PlaneLabel::kOther:
      return "other";
  }
  return "";
}

}  // namespace facet
