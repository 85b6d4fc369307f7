// SPDX-License-Identifier: BSD-2-Clause
#include "facet/camera/lens_models.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/camera/camera_model.h"
#include "facet/testing/lens_examples.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

Vector2d PixelOf(const CameraIntrinsics& k, const Vector2d& m) {
  return {k.fx * m.x() + k.cx, k.fy * m.y() + k.cy};
}

// Each against the projection of a point in space as its paper has it, which knows no plane z = 1.
TEST(LensModelsTest, AgreeWithTheFormulasOfTheirPapers) {
  const CameraIntrinsics ds = testing::LensExample(DistortionModel::kDoubleSphere);
  const CameraIntrinsics eucm = testing::LensExample(DistortionModel::kExtendedUnified);
  const CameraIntrinsics omni = testing::LensExample(DistortionModel::kUnified);
  const CameraIntrinsics fov = testing::LensExample(DistortionModel::kFieldOfView);
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const Vector3d p(rng.Uniform(-3, 3), rng.Uniform(-2, 2), rng.Uniform(1, 4));
    const double R2 = p.head<2>().squaredNorm(), R = std::sqrt(R2);

    double xi = ds.coefficients[0], alpha = ds.coefficients[1];
    const double d1 = p.norm(), shifted = xi * d1 + p.z(), d2 = std::hypot(R, shifted);
    Vector2d expected = PixelOf(ds, p.head<2>() / (alpha * d2 + (1 - alpha) * shifted));
    EXPECT_LT((*CameraModel(ds).Project(p) - expected).norm(), 1e-9);

    alpha = eucm.coefficients[0];
    const double d = std::sqrt(eucm.coefficients[1] * R2 + p.z() * p.z());
    expected = PixelOf(eucm, p.head<2>() / (alpha * d + (1 - alpha) * p.z()));
    EXPECT_LT((*CameraModel(eucm).Project(p) - expected).norm(), 1e-9);

    xi = omni.coefficients[4];
    const Vector3d s = p.normalized();
    const double x = s.x() / (s.z() + xi), y = s.y() / (s.z() + xi), r2 = x * x + y * y;
    const auto& c = omni.coefficients;
    const double radial = 1 + c[0] * r2 + c[1] * r2 * r2;
    expected = PixelOf(omni,
                       {x * radial + 2 * c[2] * x * y + c[3] * (r2 + 2 * x * x),
                        y * radial + c[2] * (r2 + 2 * y * y) + 2 * c[3] * x * y});
    EXPECT_LT((*CameraModel(omni).Project(p) - expected).norm(), 1e-9);

    const double w = fov.coefficients[0];
    const double seen = std::atan(2 * R / p.z() * std::tan(w / 2)) / w;
    expected = PixelOf(fov, p.head<2>() * (seen / R));
    EXPECT_LT((*CameraModel(fov).Project(p) - expected).norm(), 1e-9);
  }
}

// The formula of OpenCV's documentation.
TEST(LensModelsTest, TheRationalModelIsThatOfOpenCv) {
  for (const CameraIntrinsics& k : testing::LensExamples()) {
    if (k.distortion != DistortionModel::kRational) continue;
    const auto& c = k.coefficients;
    const double x = 0.4, y = -0.3, r2 = 0.25;
    const double radial = (1 + c[0] * r2 + c[1] * r2 * r2 + c[4] * r2 * r2 * r2) /
                          (1 + c[5] * r2 + c[6] * r2 * r2 + c[7] * r2 * r2 * r2);
    const Vector2d expected = PixelOf(k,
                                      {x * radial + 2 * c[2] * x * y + c[3] * (r2 + 2 * x * x),
                                       y * radial + c[2] * (r2 + 2 * y * y) + 2 * c[3] * x * y});
    EXPECT_LT((*CameraModel(k).Project(Vector3d(x, y, 1)) - expected).norm(), 1e-9);
  }
}

// With these coefficients two models are the same lens.
TEST(LensModelsTest, SpecialCasesAgree) {
  CameraIntrinsics unified = testing::LensExample(DistortionModel::kUnified);
  const double xi = unified.coefficients[4];
  unified.coefficients = {0, 0, 0, 0, xi};
  CameraIntrinsics extended = unified;
  extended.distortion = DistortionModel::kExtendedUnified;
  extended.coefficients = {xi / (1 + xi), 1};
  extended.fx = unified.fx / (1 + xi), extended.fy = unified.fy / (1 + xi);
  CameraIntrinsics sphere = extended;
  sphere.distortion = DistortionModel::kDoubleSphere;
  sphere.coefficients = {0, xi / (1 + xi)};
  CameraIntrinsics rational = testing::LensExample(DistortionModel::kRadialTangential);
  const CameraIntrinsics plain = rational;
  rational.distortion = DistortionModel::kRational;
  for (const double x : {-1.1, -0.2, 0.0, 0.6}) {
    const Vector3d p(x, 0.4, 1);
    const Vector2d px = *CameraModel(unified).Project(p);
    EXPECT_LT((*CameraModel(extended).Project(p) - px).norm(), 1e-9);
    EXPECT_LT((*CameraModel(sphere).Project(p) - px).norm(), 1e-9);
    EXPECT_LT((*CameraModel(rational).Project(p) - *CameraModel(plain).Project(p)).norm(), 1e-9);
  }
  EXPECT_NEAR(CameraModel(unified).mean_focal_px(), CameraModel(extended).mean_focal_px(), 1e-9);
}

TEST(LensModelsTest, PixelsPerRadianAreThoseAtTheAxis) {
  for (const CameraIntrinsics& k : testing::LensExamples()) {
    const CameraModel camera(k);
    const double step = 1e-6;
    const Vector2d moved =
        *camera.Project(Vector3d(step, 0, 1)) - *camera.Project(Vector3d(0, 0, 1));
    EXPECT_NEAR(moved.norm() / step, camera.mean_focal_px(), 0.01 * camera.mean_focal_px());
  }
}

TEST(LensModelsTest, DerivativesByTheFirstFourCoefficients) {
  for (const CameraIntrinsics& k : testing::LensExamples()) {
    if (k.distortion == DistortionModel::kNone ||
        k.distortion == DistortionModel::kRadialTangential ||
        k.distortion == DistortionModel::kEquidistant) {
      continue;
    }
    for (const Vector2d& xy : {Vector2d(0.5, -0.3), Vector2d(-0.1, 0.9), Vector2d(0, 0)}) {
      const auto distort = [&](const Vector4d& change) {
        CameraIntrinsics changed = k;
        for (std::size_t i = 0; i < 4; ++i) {
          if (i < NumCoefficients(k.distortion))
            changed.coefficients[i] += change(static_cast<Eigen::Index>(i));
        }
        return DistortThroughLens(changed, xy, nullptr);
      };
      testing::ExpectJacobian<2, 4>(LensCoefficientJacobian(k, xy), distort, 1e-6);
    }
  }
}

TEST(LensModelsTest, CoefficientsThatNoLensHasAreRefused) {
  const auto complaint = [](DistortionModel model, std::size_t index, double value) {
    CameraIntrinsics k = testing::LensExample(model);
    k.coefficients[index] = value;
    return CameraModel::WhatIsWrong(k);
  };
  EXPECT_NE(complaint(DistortionModel::kFieldOfView, 0, 0).find("field of view"),
            std::string::npos);
  EXPECT_NE(complaint(DistortionModel::kFieldOfView, 0, 4).find("field of view"),
            std::string::npos);
  EXPECT_NE(complaint(DistortionModel::kDoubleSphere, 0, -1).find("xi"), std::string::npos);
  EXPECT_NE(complaint(DistortionModel::kDoubleSphere, 1, 1.1).find("alpha"), std::string::npos);
  EXPECT_NE(complaint(DistortionModel::kExtendedUnified, 0, -0.1).find("alpha"), std::string::npos);
  EXPECT_NE(complaint(DistortionModel::kExtendedUnified, 1, 0).find("beta"), std::string::npos);
  EXPECT_NE(complaint(DistortionModel::kUnified, 4, -1).find("xi"), std::string::npos);
  for (const CameraIntrinsics& k : testing::LensExamples())
    EXPECT_EQ(CameraModel::WhatIsWrong(k), "");
}

TEST(LensModelsTest, TheViewEndsAtAPole) {
  CameraIntrinsics pole = testing::LensExample(DistortionModel::kRational);
  pole.coefficients = {0, 0, 0, 0, 0, -0.5, 0, 0};  // at a radius of the square root of 2
  ASSERT_EQ(CameraModel::WhatIsWrong(pole), "");
  EXPECT_LT(std::tan(CameraModel(pole).max_angle()), std::sqrt(2.0));
  EXPECT_FALSE(CameraModel(pole).Project(Vector3d(1.5, 0, 1)));
}

}  // namespace
}  // namespace facet
