// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/measured_ray.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/camera/camera_model.h"
#include "facet/testing/lens_examples.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

MeasuredRay RayOf(const CameraModel& camera, const Vector2d& px, double sigma_px) {
  const PixelBearing seen = *camera.BearingOf(px);
  return {seen.bearing, seen.J_px_bearing / sigma_px};
}

TEST(MeasuredRayTest, TheErrorIsThatOfThePixelToFirstOrder) {
  Rng rng(1);
  for (const CameraIntrinsics& k : testing::LensExamples()) {
    const CameraModel camera(k);
    for (int i = 0; i < 20; ++i) {
      const Vector2d px(rng.Uniform(0, k.width - 1), rng.Uniform(0, k.height - 1));
      const Vector2d off_px(rng.Uniform(-0.5, 0.5), rng.Uniform(-0.5, 0.5));
      const auto moved = camera.Unproject(px + off_px);
      if (!moved) continue;
      const Vector2d error = RayOf(camera, px, 0.25).Error(rng.Uniform(0.1, 9) * *moved);
      EXPECT_LT((0.25 * error - off_px).norm(), 0.02 * off_px.norm()) << px.transpose();
    }
  }
}

TEST(MeasuredRayTest, ItsDerivativeIsTheNumericOne) {
  const MeasuredRay ray = RayOf(CameraModel(testing::LensExamples()[1]), {150, 400}, 0.3);
  for (const Vector3d& off : {Vector3d(0, 0, 0), Vector3d(0.1, -0.3, 0.2), Vector3d(1, 1, 0.1)}) {
    const Vector3d h = 0.7 * (ray.bearing + off);
    ASSERT_TRUE(ray.IsNear(h));
    const auto error = [&](const Vector3d& d) { return ray.Error(h + d); };
    testing::ExpectJacobian<2, 3>(ray.ErrorByDirection(h), error, 1e-6);
    EXPECT_LT((ray.ErrorByDirection(h) * h).norm(), 1e-9) << "along itself";
  }
}

TEST(MeasuredRayTest, WhatIsBesideOrBehindIsNotNear) {
  MeasuredRay ray;
  EXPECT_TRUE(ray.IsNear({0.5, 0.5, 0.3}));
  EXPECT_FALSE(ray.IsNear({1, 0, 0.01}));
  EXPECT_FALSE(ray.IsNear({0, 0, -1}));
}

TEST(MeasuredRayTest, AngleInformationIsThatOfTheSigmaInTheMiddleOfThePinhole) {
  const CameraIntrinsics k = testing::LensExample(DistortionModel::kNone);
  const MeasuredRay ray = RayOf(CameraModel(k), {k.cx, k.cy}, 0.5);
  EXPECT_NEAR(ray.AngleInformation(), k.fx * k.fy / (0.5 * 0.5), 1e-6 * k.fx * k.fy);
}

}  // namespace
}  // namespace facet
