// SPDX-License-Identifier: BSD-2-Clause
#include "facet/camera/image_extent.h"

#include <gtest/gtest.h>

#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

CameraIntrinsics Resized(CameraIntrinsics k, double factor) {
  k.width = static_cast<int>(k.width * factor);
  k.height = static_cast<int>(k.height * factor);
  for (double* length : {&k.fx, &k.fy, &k.cx, &k.cy})
    *length *= factor;
  return k;
}

TEST(ImageExtentTest, EurocIsTheMeasure) {
  const CameraModel camera = EurocRig().cameras[0];
  EXPECT_EQ(RelativeImageSide(camera), 1);
  EXPECT_NEAR(RelativeViewAngle(camera), 1, 1e-12);
}

TEST(ImageExtentTest, MorePixelsOfTheSameView) {
  const CameraModel camera(Resized(EurocRig().cameras[0].intrinsics(), 2));
  EXPECT_NEAR(RelativeImageSide(camera), 2, 1e-12);
  EXPECT_NEAR(RelativeViewAngle(camera), 1, 1e-12);
}

TEST(ImageExtentTest, CornersThatTheLensDoesNotSeeDoNotCount) {
  CameraIntrinsics k;
  k.width = k.height = 800;
  k.cx = k.cy = 399.5;
  k.fx = k.fy = 200;  // 110 deg are a circle with a radius of 384 px
  k.distortion = DistortionModel::kEquidistant;
  k.coefficients.fill(0);
  const CameraModel camera(k);
  const double circle = 3.14159265 * 383.97 * 383.97;
  EXPECT_NEAR(RelativeImageSide(camera), std::sqrt(circle / (752 * 480)), 0.01);
  EXPECT_NEAR(RelativeViewAngle(camera), RelativeImageSide(camera) * 457.975 / 200, 1e-9);
}

}  // namespace
}  // namespace facet
