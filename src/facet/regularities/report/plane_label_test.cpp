// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/report/plane_label.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

PlaneRecord Level(double height_m, double area_m2, double up = 1) {
  PlaneRecord record;
  record.plane_W = {up * Vector3d::UnitZ(), up * height_m};
  record.centroid_W = {0, 0, height_m};
  record.area_m2 = area_m2;
  record.orientation = PlaneOrientation::kHorizontal;
  return record;
}

PlaneRecord Upright(double area_m2) {
  PlaneRecord record;
  record.plane_W = {Vector3d::UnitX(), 2};
  record.area_m2 = area_m2;
  record.orientation = PlaneOrientation::kVertical;
  return record;
}

std::vector<PlaneLabel> LabelsOf(std::vector<PlaneRecord> planes) {
  LabelPlanes(planes);
  std::vector<PlaneLabel> out;
  for (const PlaneRecord& plane : planes)
    out.push_back(plane.label);
  return out;
}

TEST(PlaneLabelTest, NamesARoom) {
  EXPECT_EQ(LabelsOf({Level(-1.5, 6),
                      Level(-0.8, 0.6),
                      Level(1.2, 3, -1),
                      Upright(4),
                      Upright(0.5),
                      Level(-1.45, 0.2),
                      Level(0.4, 1),
                      Level(-0.8, 1, -1)}),
            (std::vector{PlaneLabel::kFloor,
                         PlaneLabel::kTable,
                         PlaneLabel::kCeiling,
                         PlaneLabel::kWall,
                         PlaneLabel::kOther,     // too small for a wall
                         PlaneLabel::kFloor,     // beside the large one
                         PlaneLabel::kOther,     // a shelf at 1.9 m
                         PlaneLabel::kOther}));  // a table from below
}

TEST(PlaneLabelTest, WithoutAFloorNothingStandsOnIt) {
  EXPECT_EQ(LabelsOf({Level(0.7, 0.3), Level(2.5, 4, -1), Upright(2)}),
            (std::vector{PlaneLabel::kOther, PlaneLabel::kOther, PlaneLabel::kWall}));
  EXPECT_TRUE(LabelsOf({}).empty());
}

TEST(PlaneLabelTest, ObliquePlanesHaveNoName) {
  PlaneRecord roof = Level(2, 5);
  roof.orientation = PlaneOrientation::kOblique;
  roof.label = PlaneLabel::kFloor;
  EXPECT_EQ(LabelsOf({roof}), std::vector{PlaneLabel::kOther});
}

}  // namespace
}  // namespace facet
