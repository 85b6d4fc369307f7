// SPDX-License-Identifier: BSD-2-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/camera/camera_model.h"
#include "facet/camera/plane_lens.h"
#include "facet/camera/wide_lens.h"
#include "facet/testing/lens_examples.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

Vector2d PixelOf(const CameraIntrinsics& k, const Vector2d& m) {
  return {k.fx * m.x() + k.cx, k.fy * m.y() + k.cy};
}

// Each against the projection of a point in space as its paper has it, which knows no plane z = 1.
TEST(LensTest, AgreeWithTheFormulasOfTheirPapers) {
  const CameraIntrinsics ds = testing::LensExample(DistortionModel::kDoubleSphere);
  const CameraIntrinsics eucm = testing::LensExample(DistortionModel::kExtendedUnified);
  const CameraIntrinsics omni = testing::LensExample(DistortionModel::kUnified);
  const CameraIntrinsics fov = testing::LensExample(DistortionModel::kFieldOfView);
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const Vector3d p(rng.Uniform(-3, 3), rng.Uniform(-2, 2), rng.Uniform(-0.2, 4));
    if (p.head<2>().norm() > 3 * std::abs(p.z()) && p.z() > 0.3) continue;
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
    const double seen = std::atan2(2 * R * std::tan(w / 2), p.z()) / w;
    expected = PixelOf(fov, p.head<2>() * (seen / R));
    EXPECT_LT((*CameraModel(fov).Project(p) - expected).norm(), 1e-9);
  }
}

// The formula of OpenCV's documentation.
TEST(LensTest, TheRationalModelIsThatOfOpenCv) {
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
TEST(LensTest, SpecialCasesAgree) {
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

TEST(LensTest, PixelsPerRadianAreThoseAtTheAxis) {
  for (const CameraIntrinsics& k : testing::LensExamples()) {
    const CameraModel camera(k);
    const double step = 1e-6;
    const Vector2d moved =
        *camera.Project(Vector3d(step, 0, 1)) - *camera.Project(Vector3d(0, 0, 1));
    EXPECT_NEAR(moved.norm() / step, camera.mean_focal_px(), 0.01 * camera.mean_focal_px());
  }
}

TEST(LensTest, DerivativesByTheFirstFourCoefficients) {
  for (const CameraIntrinsics& k : testing::LensExamples()) {
    const bool is_wide = IsWideLens(k.distortion);
    for (const Vector3d& h : {Vector3d(0.5, -0.3, 1),
                              Vector3d(-0.2, 1.8, 2),
                              Vector3d(0, 0, 1),
                              Vector3d(0.9, 0.3, -0.1)}) {
      if (!is_wide && h.z() < 0) continue;
      const auto distort = [&](const Vector4d& change) {
        CameraIntrinsics changed = k;
        for (std::size_t i = 0; i < 4; ++i) {
          if (i < NumCoefficients(k.distortion))
            changed.coefficients[i] += change(static_cast<Eigen::Index>(i));
        }
        return is_wide ? *ProjectThroughWideLens(changed, h, nullptr)
                       : DistortThroughPlaneLens(changed, h.hnormalized(), nullptr);
      };
      const Matrix<2, 4> J = is_wide ? WideLensCoefficientJacobian(k, h)
                                     : PlaneLensCoefficientJacobian(k, h.hnormalized());
      testing::ExpectJacobian<2, 4>(J, distort, 1e-6);
    }
  }
}

// Rays beside and behind the camera, which a wide lens sees.
TEST(LensTest, WideLensesSeeBesideThemselves) {
  int num_lenses = 0;
  for (const CameraIntrinsics& k : testing::LensExamples()) {
    if (!IsWideLens(k.distortion)) continue;
    const CameraModel camera(k);
    const double end_deg = camera.max_angle() * 180 / M_PI;
    if (end_deg < 95) continue;
    ++num_lenses;
    for (const double angle_deg : {80.0, 88.0, 90.0, 92.0, 94.0, end_deg - 1}) {
      const double angle = angle_deg * M_PI / 180;
      const Vector3d ray(0.6 * std::sin(angle), -0.8 * std::sin(angle), std::cos(angle));
      Matrix<2, 3> J;
      const auto px = camera.Project(2.5 * ray, &J);
      ASSERT_TRUE(px) << angle_deg;
      const auto f = [&](const Vector3d& d) { return *camera.Project(2.5 * ray + d); };
      testing::ExpectJacobian<2, 3>(J, f, 1e-6);
      const auto back = camera.BearingOf(*px);
      ASSERT_TRUE(back) << angle_deg;
      EXPECT_LT((back->bearing - ray).norm(), 1e-9) << angle_deg;
    }
  }
  EXPECT_GE(num_lenses, 3);
}

// A lens of TUM-VI's kind: 190 deg, and every pixel of its image circle has a ray.
TEST(LensTest, AFisheyeOf190DegreesSeesItsWholeCircle) {
  const CameraIntrinsics k{512,
                           512,
                           191,
                           191,
                           255,
                           257,
                           DistortionModel::kEquidistant,
                           {0.0034, 0.0007, -0.002, 0.0002}};
  const CameraModel camera(k);
  EXPECT_GT(camera.max_angle(), 100 * M_PI / 180);
  for (int i = 0; i < 64; ++i) {
    const double turn = 2 * M_PI * i / 64, angle = 95 * M_PI / 180;
    const Vector3d ray(
        std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn), std::cos(angle));
    const auto px = camera.Project(ray);
    ASSERT_TRUE(px);
    EXPECT_LT((*camera.Unproject(*px) - ray).norm(), 1e-9);
  }
}

TEST(LensTest, CoefficientsThatNoLensHasAreRefused) {
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

TEST(LensTest, TheViewEndsAtAPole) {
  CameraIntrinsics pole = testing::LensExample(DistortionModel::kRational);
  pole.coefficients = {0, 0, 0, 0, 0, -0.5, 0, 0};  // at a radius of the square root of 2
  ASSERT_EQ(CameraModel::WhatIsWrong(pole), "");
  EXPECT_LT(std::tan(CameraModel(pole).max_angle()), std::sqrt(2.0));
  EXPECT_FALSE(CameraModel(pole).Project(Vector3d(1.5, 0, 1)));
}

}  // namespace
}  // namespace facet
