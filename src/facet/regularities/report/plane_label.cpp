// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/report/plane_label.h"

#include <algorithm>
#include <optional>

namespace facet {

namespace {
constexpr double kFloorStep_m = 0.1;  // floors of one storey differ less
constexpr double kMinFloorArea_m2 = 0.5;
constexpr double kMinTable_m = 0.3, kMaxTable_m = 1.3;
constexpr double kMinCeiling_m = 1.8;
constexpr double kMinWallArea_m2 = 1.0;
}  // namespace

void LabelPlanes(std::vector<PlaneRecord>& planes) {
  std::optional<double> floor;
  for (const PlaneRecord& plane : planes) {
    const bool may_be_floor = plane.orientation == PlaneOrientation::kHorizontal &&
                              plane.plane_W.n.z() > 0 && plane.area_m2 >= kMinFloorArea_m2;
    if (may_be_floor) floor = std::min(floor.value_or(plane.centroid_W.z()), plane.centroid_W.z());
  }
  for (PlaneRecord& plane : planes) {
    plane.label = PlaneLabel::kOther;
    if (plane.orientation == PlaneOrientation::kVertical) {
      if (plane.area_m2 >= kMinWallArea_m2) plane.label = PlaneLabel::kWall;
    } else if (plane.orientation == PlaneOrientation::kHorizontal && floor) {
      const double height = plane.centroid_W.z() - *floor;
      const bool is_seen_from_above = plane.plane_W.n.z() > 0;
      if (is_seen_from_above && height < kFloorStep_m) plane.label = PlaneLabel::kFloor;
      if (is_seen_from_above && height >= kMinTable_m && height <= kMaxTable_m)
        plane.label = PlaneLabel::kTable;
      if (!is_seen_from_above && height >= kMinCeiling_m) plane.label = PlaneLabel::kCeiling;
    }
  }
}

}  // namespace facet
