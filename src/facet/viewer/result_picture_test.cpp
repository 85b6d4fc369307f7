// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/result_picture.h"

#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/io/result_writer.h"
#include "facet/testing/io/test_sequence.h"
#include "facet/viewer/rasteriser.h"

namespace facet {
namespace {

constexpr Colour kWhite = {255, 255, 255}, kRed = {255, 0, 0}, kBlue = {0, 0, 255};

/// A square in the plane x = `depth`, seen along x.
void DrawSquare(double depth, double half, const Colour& colour, Rasteriser& out) {
  const ViewPoint view({0, 0, 0}, {1, 0, 0}, 90, 40, 20);
  const Vector3d a(depth, -half, -half), b(depth, half, -half), c(depth, half, half),
      d(depth, -half, half);
  out.DrawTriangle(view, {a, b, c}, {colour, colour, colour});
  out.DrawTriangle(view, {a, c, d}, {colour, colour, colour});
}

TEST(Rasteriser, WhatIsNearerHidesWhatIsFartherInAnyOrder) {
  for (bool near_first : {true, false}) {
    Rasteriser out(40, 20, kWhite);
    if (near_first) DrawSquare(1, 0.5, kRed, out);
    DrawSquare(2, 1.8, kBlue, out);
    if (!near_first) DrawSquare(1, 0.5, kRed, out);
    const cv::Mat image = out.Image();
    EXPECT_EQ(image.at<cv::Vec3b>(10, 20), cv::Vec3b(255, 0, 0));
    EXPECT_EQ(image.at<cv::Vec3b>(2, 20), cv::Vec3b(0, 0, 255));
    EXPECT_EQ(image.at<cv::Vec3b>(10, 2), cv::Vec3b(255, 255, 255));
  }
}

TEST(Rasteriser, UpIsUpAndLeftIsLeft) {
  const ViewPoint view({0, 0, 0}, {1, 0, 0}, 90, 40, 20);
  const Vector3d up = view.ToImage(view.ToCamera({2, 0, 1}));
  const Vector3d left = view.ToImage(view.ToCamera({2, 1, 0}));
  EXPECT_NEAR(up.y(), 5, 1e-9);
  EXPECT_NEAR(left.x(), 15, 1e-9);
}

TEST(Rasteriser, ATriangleThatReachesBehindTheCameraIsCut) {
  Rasteriser out(40, 20, kWhite);
  const ViewPoint view({0, 0, 0}, {1, 0, 0}, 90, 40, 20);
  out.DrawTriangle(
      view, {Vector3d(-5, -3, -1), Vector3d(-5, 3, -1), Vector3d(50, 0, -1)}, {kRed, kRed, kRed});
  out.DrawLine(view, {-5, 0, 1}, {5, 0, 1}, kBlue, 2);
  const cv::Mat image = out.Image();
  EXPECT_EQ(image.at<cv::Vec3b>(18, 20), cv::Vec3b(255, 0, 0));
  EXPECT_EQ(image.at<cv::Vec3b>(4, 20), cv::Vec3b(0, 0, 255));
}

TEST(ResultPicture, FacesAreDrawnFromTheirFront) {
  const TempFolder folder;
  RunRecord run;
  TriangleMesh& mesh = run.map.emplace();
  mesh.vertices = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  mesh.normals.assign(4, {0, 0, 1});
  mesh.plane_ids = {0, 0};
  WriteResult(folder.path(), run);
  PictureOptions options;
  options.width = 60;
  options.height = 40;
  options.has_trajectory = false;  // there is none
  options.view = "top";
  const cv::Vec3b middle = DrawResult(folder.path(), options).at<cv::Vec3b>(20, 30);
  EXPECT_GT(middle[2], middle[0] + 50);  // the blue of plane 0
  options.from_W = {2, 2.01, -9};
  options.to_W = {2, 2, 0};
  EXPECT_EQ(DrawResult(folder.path(), options).at<cv::Vec3b>(20, 30), cv::Vec3b(255, 255, 255));
  options.has_back_sides = true;
  EXPECT_NE(DrawResult(folder.path(), options).at<cv::Vec3b>(20, 30), cv::Vec3b(255, 255, 255));
  options.mesh = "horizon";
  EXPECT_THROW(DrawResult(folder.path(), options), InputError);
}

}  // namespace
}  // namespace facet
