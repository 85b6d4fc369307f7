// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/mesh_in_image.h"

#include <gtest/gtest.h>

#include "facet/viewer/base64.h"

namespace facet {
namespace {

CameraModel SmallCamera() {
  CameraIntrinsics k;
  k.width = 100;
  k.height = 80;
  k.fx = k.fy = 50;
  k.cx = 50;
  k.cy = 40;
  return CameraModel(k);
}

/// A square of 2 x 2 m that faces a camera at the origin which looks along z.
void AddSquare(double z, int plane_id, TriangleMesh& mesh) {
  const int n = static_cast<int>(mesh.vertices.size());
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    mesh.vertices.emplace_back(x, y, z);
  mesh.faces.push_back({n, n + 2, n + 1});
  mesh.faces.push_back({n, n + 3, n + 2});
  mesh.plane_ids.insert(mesh.plane_ids.end(), {plane_id, plane_id});
}

TEST(MeshInImage, PixelsAreWhereTheCameraHasThem) {
  TriangleMesh mesh;
  AddSquare(4, 7, mesh);
  const SE3 T_WC(Quaterniond::Identity(), {0.4, 0, 0});
  const MeshInImage seen = SeeMesh(mesh, SmallCamera(), T_WC);
  ASSERT_EQ(seen.faces.size(), 2u);
  EXPECT_EQ(seen.plane_ids, (std::vector<int>{7, 7}));
  ASSERT_EQ(seen.pixels.size(), 4u);
  const Vector2d first = seen.pixels[seen.faces[0][0]];
  EXPECT_NEAR(first.x(), 50 + 50 * (-1 - 0.4) / 4, 1e-9);
  EXPECT_NEAR(first.y(), 40 + 50 * -1.0 / 4, 1e-9);
  EXPECT_NEAR(seen.depths_m[0], 4, 1e-12);
}

TEST(MeshInImage, WhatIsHiddenOrSeenFromBehindOrBehindTheCameraIsNotThere) {
  TriangleMesh mesh;
  AddSquare(5, 1, mesh);
  AddSquare(2, 2, mesh);   // hides all of it
  AddSquare(-3, 3, mesh);  // behind the camera
  EXPECT_EQ(SeeMesh(mesh, SmallCamera(), SE3()).plane_ids, (std::vector<int>{2, 2}));
  for (auto& face : mesh.faces)
    std::swap(face[1], face[2]);
  EXPECT_TRUE(SeeMesh(mesh, SmallCamera(), SE3()).faces.empty());
  EXPECT_TRUE(SeeMesh(TriangleMesh(), SmallCamera(), SE3()).pixels.empty());
}

TEST(MeshInImage, ThePictureHoldsItsImage) {
  TriangleMesh mesh;
  AddSquare(4, 1, mesh);
  const std::string svg =
      MeshImageSvg(cv::Mat(80, 100, CV_8UC1, cv::Scalar(90)), SeeMesh(mesh, SmallCamera(), SE3()));
  EXPECT_TRUE(svg.starts_with("<svg"));
  EXPECT_TRUE(svg.ends_with("</svg>"));
  EXPECT_NE(svg.find("viewBox=\"0 0 100 80\""), std::string::npos);
  EXPECT_NE(svg.find("base64,/9j/"), std::string::npos);  // JPEG
  EXPECT_NE(svg.find("stroke=\"#e69f00\""), std::string::npos);
  EXPECT_NE(svg.find("d=\"M37.5 27.5L62.5 52.5L62.5 27.5Z"), std::string::npos) << svg;
}

}  // namespace
}  // namespace facet
