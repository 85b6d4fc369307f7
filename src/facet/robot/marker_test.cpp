// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/marker.h"

#include <cstring>

#include <gtest/gtest.h>

namespace facet {
namespace robot {
namespace {

api::Mesh TwoTriangles() {
  api::Mesh mesh;
  mesh.vertices = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 2.5}}};
  mesh.faces = {{{0, 1, 2}}, {{0, 2, 3}}};
  mesh.colours = {{{255, 0, 0}}, {{0, 255, 0}}, {{0, 0, 255}}, {{1, 2, 3}}};
  return mesh;
}

TEST(MarkerTest, AMeshIsAListOfTriangles) {
  const Marker marker = MeshMarker(5, "map", 7, TwoTriangles());
  EXPECT_EQ(marker.type, Marker::kTriangles);
  EXPECT_EQ(marker.action, Marker::kAdd);
  EXPECT_EQ(marker.id, 7);
  ASSERT_EQ(marker.points.size(), 6u);
  ASSERT_EQ(marker.colours.size(), 6u);
  EXPECT_EQ(marker.points[5][2], 2.5);
  EXPECT_EQ(marker.colours[1], (Colour{{0, 1, 0, 1}}));
}

TEST(MarkerTest, AMeshWithoutFacesRemovesTheOneBefore) {
  const Marker marker = MeshMarker(5, "map", 7, api::Mesh());
  EXPECT_EQ(marker.action, Marker::kDelete);
  EXPECT_EQ(marker.name, "map");
  EXPECT_EQ(marker.id, 7);
}

TEST(MarkerTest, PlanesAreOutlinesAndLabelsAndGoAgain) {
  api::Plane plane;
  plane.id = 3;
  plane.label = "floor";
  plane.outline = {{{0, 0, 0}}, {{2, 0, 0}}, {{2, 2, 0}}, {{0, 2, 0}}};
  api::Plane without_outline;
  const std::vector<Marker> markers = PlaneMarkers({5, {plane, without_outline}, {8}});
  ASSERT_EQ(markers.size(), 4u);
  EXPECT_EQ(markers[0].points.size(), 5u) << "closed";
  EXPECT_EQ(markers[0].points.front(), markers[0].points.back());
  EXPECT_EQ(markers[1].text, "floor 3");
  EXPECT_EQ(markers[1].position, (api::Vec3{{1, 1, 0}}));
  EXPECT_EQ(markers[2].id, 8);
  EXPECT_EQ(markers[3].action, Marker::kDelete);
}

TEST(MarkerTest, PointsHaveTheirColours) {
  const PointRows rows = ToPointRows(TwoTriangles());
  EXPECT_EQ(rows.num_points, 4u);
  EXPECT_EQ(rows.bytes_per_point, 16u);
  ASSERT_EQ(rows.bytes.size(), 64u);
  float z = 0;
  std::uint32_t rgb = 0;
  std::memcpy(&z, &rows.bytes[3 * 16 + 8], 4);
  std::memcpy(&rgb, &rows.bytes[3 * 16 + 12], 4);
  EXPECT_EQ(z, 2.5F);
  EXPECT_EQ(rgb, 0x010203u);
  EXPECT_TRUE(ToPointRows(api::Mesh()).bytes.empty());
}

}  // namespace
}  // namespace robot
}  // namespace facet
