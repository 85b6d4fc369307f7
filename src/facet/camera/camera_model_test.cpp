// SPDX-License-Identifier: BSD-2-Clause
#include "facet/camera/camera_model.h"

#include <limits>

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/base/random.h"
#include "facet/testing/lens_examples.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

CameraIntrinsics EurocLeft() {
  return testing::LensExample(DistortionModel::kRadialTangential);
}

CameraIntrinsics Fisheye() {
  return testing::LensExample(DistortionModel::kEquidistant);
}

class EveryModelTest : public ::testing::TestWithParam<CameraIntrinsics> {};

INSTANTIATE_TEST_SUITE_P(Models, EveryModelTest, ::testing::ValuesIn(testing::LensExamples()));

TEST_P(EveryModelTest, PixelsSurviveTheRoundTripOverTheWholeImage) {
  const CameraModel camera(GetParam());
  for (int row = 0; row <= camera.height(); row += 12) {
    for (int col = 0; col <= camera.width(); col += 12) {
      const Vector2d px(std::min(col, camera.width() - 1), std::min(row, camera.height() - 1));
      const auto bearing = camera.Unproject(px);
      ASSERT_TRUE(bearing) << px.transpose();
      EXPECT_NEAR(bearing->norm(), 1.0, 1e-12);
      const auto back = camera.Project(3.7 * *bearing);
      ASSERT_TRUE(back) << px.transpose();
      EXPECT_LT((*back - px).norm(), 1e-8) << px.transpose();
    }
  }
}

TEST_P(EveryModelTest, PointsSurviveTheRoundTrip) {
  const CameraModel camera(GetParam());
  Rng rng(1);
  for (int i = 0; i < 2000; ++i) {
    const Vector2d xy(rng.Uniform(-1.1, 1.1), rng.Uniform(-1.1, 1.1));
    const auto px = camera.Project(2.0 * xy.homogeneous());
    ASSERT_TRUE(px);
    const auto bearing = camera.Unproject(*px);
    ASSERT_TRUE(bearing) << xy.transpose();
    EXPECT_LT((bearing->hnormalized() - xy).norm(), 1e-9) << xy.transpose();
  }
}

// Newton's method from where the pixel is seen ends at a point behind the fold there.
TEST(CameraModelTest, ABearingInAPincushionIsTheOneInView) {
  CameraIntrinsics k;
  k.width = 752;
  k.height = 480;
  k.fx = k.fy = 300;
  k.cx = 376;
  k.cy = 240;
  k.distortion = DistortionModel::kRadialTangential;
  k.coefficients = {0.4397, -0.2404, 0.0041, 0.0042};
  const CameraModel camera(k);
  const Vector2d px(k.cx - 1.1460 * k.fx, k.cy + 0.5304 * k.fy);
  const auto bearing = camera.Unproject(px);
  ASSERT_TRUE(bearing);
  EXPECT_LT((bearing->hnormalized() - Vector2d(-0.9719, 0.4439)).norm(), 1e-3);
  EXPECT_LT((*camera.Project(*bearing) - px).norm(), 1e-6);
}

TEST_P(EveryModelTest, ProjectionJacobianMatchesNumericDerivative) {
  const CameraModel camera(GetParam());
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    // The first ones lie on and very near the optical axis.
    const double spread = i < 3 ? 1e-6 * i : 1.2;
    const Vector3d p_C =
        rng.Uniform(0.5, 8.0) *
        Vector2d(rng.Uniform(-spread, spread), rng.Uniform(-spread, spread)).homogeneous();
    Matrix<2, 3> J;
    ASSERT_TRUE(camera.Project(p_C, &J));
    const auto f = [&](const Vector3d& d) { return *camera.Project(p_C + d); };
    testing::ExpectJacobian<2, 3>(J, f, 1e-6);
  }
}

TEST_P(EveryModelTest, TheDerivativeOfTheBearingMatchesTheNumericOne) {
  const CameraModel camera(GetParam());
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const Vector2d px(rng.Uniform(0, camera.width() - 1), rng.Uniform(0, camera.height() - 1));
    const auto seen = camera.BearingOf(px);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->bearing.norm(), 1, 1e-12);
    EXPECT_LT((seen->J_px_bearing * seen->bearing).norm(), 1e-9);
    Matrix<2, 3> J;
    ASSERT_TRUE(camera.Project(seen->bearing, &J));
    EXPECT_LT((J - seen->J_px_bearing).norm(), 1e-6);
    const auto f = [&](const Vector2d& d) { return *camera.Unproject(px + d); };
    testing::ExpectJacobian<3, 2>(AcrossRay(seen->J_px_bearing), f, 1e-8, 1e-3);
  }
}

TEST_P(EveryModelTest, NothingIsSeenBehindTheCameraOrBesideIt) {
  const CameraModel camera(GetParam());
  EXPECT_FALSE(camera.Project(Vector3d(0.1, 0.2, -1)));
  EXPECT_FALSE(camera.Project(Vector3d(0, 0, -1)));
  EXPECT_FALSE(camera.Project(Vector3d::Zero()));
  if (camera.max_angle() < M_PI / 2) {
    EXPECT_FALSE(camera.Project(Vector3d(0.1, 0.2, 0)));
    EXPECT_FALSE(camera.Project(Vector3d(100, 0, 1)));
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(camera.Project(Vector3d(nan, 0, 1)));
  EXPECT_FALSE(camera.Project(Vector3d(0, 0, nan)));
  EXPECT_FALSE(camera.BearingOf(Vector2d(nan, 3)));
  EXPECT_FALSE(camera.BearingOf(Vector2d(1e300, -1e300)));
}

// Barrel distortion without the quartic term: the image radius is largest at r = 1 / sqrt(3 |k1|).
TEST(CameraModelTest, RefusesTheFoldOfRadialDistortion) {
  CameraIntrinsics k = EurocLeft();
  k.coefficients = {-0.25, 0, 0, 0};
  const CameraModel camera(k);
  const double fold = 1 / std::sqrt(0.75);
  EXPECT_LT(std::tan(camera.max_angle()), fold);
  EXPECT_GT(std::tan(camera.max_angle()), 0.98 * fold);
  EXPECT_TRUE(camera.Project(Vector3d(0.97 * fold, 0, 1)));
  EXPECT_FALSE(camera.Project(Vector3d(1.01 * fold, 0, 1)));
  // This point would appear in the middle of the image.
  EXPECT_FALSE(camera.Project(Vector3d(1.9, 0, 1)));
  const double largest_px = k.fx * fold * (1 - 0.25 * fold * fold);
  EXPECT_TRUE(camera.BearingOf(Vector2d(k.cx + 0.99 * largest_px, k.cy)));
  EXPECT_FALSE(camera.BearingOf(Vector2d(k.cx + 1.01 * largest_px, k.cy)));
}

TEST(CameraModelTest, RefusesTheFoldOfEquidistantDistortion) {
  CameraIntrinsics k = Fisheye();
  k.coefficients = {-0.2, 0, 0, 0};
  const CameraModel camera(k);
  const double fold = 1 / std::sqrt(0.6);  // rad
  EXPECT_NEAR(camera.max_angle(), fold, 0.02 * fold);
  const auto ray = [](double angle) { return Vector3d(0, std::sin(angle), std::cos(angle)); };
  EXPECT_TRUE(camera.Project(ray(0.97 * fold)));
  EXPECT_FALSE(camera.Project(ray(1.01 * fold)));
}

TEST(CameraModelTest, RefusesAFoldBetweenRadiiThatGrow) {
  // The slope 1 + 3 k1 r^2 + 5 k2 r^4 is lowest at r^2 = -0.3 k1 / k2, and 1 - 0.45 k1^2 / k2
  // there.
  CameraIntrinsics k = EurocLeft();
  const double lowest_r2 = 0.3 * 0.4 / 0.07;
  k.coefficients = {-0.4, 0.07, 0, 0};
  ASSERT_LT(1 - 0.45 * 0.4 * 0.4 / 0.07, 0.0);
  EXPECT_LT(std::tan(CameraModel(k).max_angle()), std::sqrt(lowest_r2));
  k.coefficients = {-0.4, 0.074, 0, 0};  // 0.027 there: it still grows
  EXPECT_NEAR(CameraModel(k).max_angle(), 85 * M_PI / 180, 1e-9);
  k.coefficients = {-0.4, 0.0733, 0, 0};  // 0.018: too slowly
  EXPECT_NEAR(std::tan(CameraModel(k).max_angle()), std::sqrt(0.3 * 0.4 / 0.0733), 0.1);
}

TEST(CameraModelTest, EurocLensNeverFolds) {
  EXPECT_NEAR(CameraModel(EurocLeft()).max_angle(), 85 * M_PI / 180, 1e-9);
}

TEST(CameraModelTest, AgreesWithKnownValues) {
  // Hand computation at x = 0.5, y = -0.25: r2 = 0.3125.
  const CameraIntrinsics k = EurocLeft();
  const double radial = 1 - 0.28340811 * 0.3125 + 0.07395907 * 0.09765625;
  const double x_d = 0.5 * radial - 0.25 * 0.00019359 + 1.76187114e-05 * (0.3125 + 0.5);
  const double y_d = -0.25 * radial + 0.00019359 * (0.3125 + 0.125) - 0.25 * 1.76187114e-05;
  const auto px = CameraModel(k).Project(Vector3d(1.0, -0.5, 2.0));
  ASSERT_TRUE(px);
  EXPECT_NEAR(px->x(), k.fx * x_d + k.cx, 1e-9);
  EXPECT_NEAR(px->y(), k.fy * y_d + k.cy, 1e-9);
}

TEST(CameraModelTest, SaysWhatIsWrong) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(CameraModel::WhatIsWrong(EurocLeft()), "");
  EXPECT_EQ(CameraModel::WhatIsWrong(Fisheye()), "");
  const auto expect_wrong = [](const char* word, auto change) {
    CameraIntrinsics k = EurocLeft();
    change(k);
    EXPECT_NE(CameraModel::WhatIsWrong(k).find(word), std::string::npos)
        << '"' << CameraModel::WhatIsWrong(k) << "\" should mention " << word;
    EXPECT_THROW(CameraModel{k}, CheckError);
  };
  expect_wrong("size", [](CameraIntrinsics& k) { k.width = 0; });
  expect_wrong("size", [](CameraIntrinsics& k) { k.height = -480; });
  expect_wrong("size", [](CameraIntrinsics& k) { k.width = 1 << 20; });
  expect_wrong("finite", [&](CameraIntrinsics& k) { k.cy = nan; });
  expect_wrong("finite", [&](CameraIntrinsics& k) { k.coefficients[3] = nan; });
  expect_wrong("positive", [](CameraIntrinsics& k) { k.fx = 0; });
  expect_wrong("positive", [](CameraIntrinsics& k) { k.fy = -458; });
  expect_wrong("does not fit", [](CameraIntrinsics& k) { k.fx = 458e6; });
  expect_wrong("does not fit", [](CameraIntrinsics& k) { k.fy = 0.458; });
  for (const double c : {1e4, 800.0, 752.0, 0.4, 0.0, -100.0}) {
    expect_wrong("principal point", [&](CameraIntrinsics& k) { k.cx = c; });
    expect_wrong("principal point", [&](CameraIntrinsics& k) { k.cy = c; });
  }
  expect_wrong("singular", [](CameraIntrinsics& k) { k.coefficients[0] = -5; });
  for (const double absurd : {1e6, 1e30, 1e300}) {
    for (const double sign : {1.0, -1.0}) {
      for (std::size_t i = 0; i < 4; ++i) {
        expect_wrong(i < 2 ? "" : "skew",
                     [&](CameraIntrinsics& k) { k.coefficients[i] = sign * absurd; });
      }
    }
    expect_wrong("magnified", [&](CameraIntrinsics& k) { k.coefficients[0] = absurd; });
  }
  CameraIntrinsics fisheye = Fisheye();
  fisheye.coefficients[3] = 1e300;
  EXPECT_NE(CameraModel::WhatIsWrong(fisheye), "");
}

TEST(CameraModelTest, CroppedImagesMayHaveTheirPrincipalPointOffTheMiddle) {
  CameraIntrinsics k = EurocLeft();
  k.height = 300;  // without the lowest 180 rows
  EXPECT_EQ(CameraModel::WhatIsWrong(k), "");
  k.cx = 100, k.width = 485;  // without the left 267 columns
  EXPECT_EQ(CameraModel::WhatIsWrong(k), "");
  k.cy = 8, k.height = 240;  // the lower half
  EXPECT_EQ(CameraModel::WhatIsWrong(k), "");
}

TEST(CameraModelTest, KnowsItsBorder) {
  const CameraModel camera(EurocLeft());
  EXPECT_TRUE(camera.IsInside(Vector2d(0, 0), 0));
  EXPECT_TRUE(camera.IsInside(Vector2d(751, 479), 0));
  EXPECT_FALSE(camera.IsInside(Vector2d(751.5, 479), 0));
  EXPECT_FALSE(camera.IsInside(Vector2d(3, 100), 4));
}

}  // namespace
}  // namespace facet
