// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/image_turner.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

CameraModel EurocCamera() {
  CameraIntrinsics k;
  k.width = 376;
  k.height = 240;
  k.fx = k.fy = 229;
  k.cx = 184;
  k.cy = 124;
  k.distortion = DistortionModel::kRadialTangential;
  k.coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
  return CameraModel(k);
}

/// A smooth world infinitely far away, by the ray in the world.
double Grey(const Vector3d& ray) {
  const Vector3d n = ray.normalized();
  return 127 + 60 * std::sin(25 * n.x()) + 60 * std::cos(31 * n.y());
}

cv::Mat Photo(const CameraModel& camera, const Matrix3d& R_WC) {
  cv::Mat image(camera.height(), camera.width(), CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      image.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(std::lround(Grey(R_WC * *camera.Unproject(Vector2d(x, y)))));
    }
  }
  return image;
}

double WorstDifference(const cv::Mat& a, const cv::Mat& b) {
  double worst = 0;
  constexpr int kBorder = 12;  // what one of them does not show
  for (int y = kBorder; y < a.rows - kBorder; ++y) {
    for (int x = kBorder; x < a.cols - kBorder; ++x)
      worst = std::max(worst, std::abs(1.0 * a.at<std::uint8_t>(y, x) - b.at<std::uint8_t>(y, x)));
  }
  return worst;
}

TEST(ImageTurnerTest, ATurnedImageIsThatOfTheTurnedCamera) {
  const CameraModel camera = EurocCamera();
  ImageTurner turner(camera);
  for (const Vector3d& turn :
       {Vector3d(0.02, 0, 0), Vector3d(0, -0.02, 0), Vector3d(0.01, 0.01, 0.02)}) {
    const Matrix3d R_WImage = ExpSO3(Vector3d(0.1, -0.2, 0.3)).toRotationMatrix();
    const Matrix3d R_WWanted = R_WImage * ExpSO3(turn).toRotationMatrix();
    cv::Mat image = Photo(camera, R_WImage);
    const cv::Mat wanted = Photo(camera, R_WWanted);
    EXPECT_GT(WorstDifference(image, wanted), 20);
    turner.Turn(R_WImage.transpose() * R_WWanted, image);
    EXPECT_LE(WorstDifference(image, wanted), 2);
  }
}

TEST(ImageTurnerTest, NoTurnChangesNothing) {
  const CameraModel camera = EurocCamera();
  const cv::Mat photo = Photo(camera, Matrix3d::Identity());
  cv::Mat image = photo.clone();
  ImageTurner(camera).Turn(Matrix3d::Identity(), image);
  EXPECT_LE(WorstDifference(image, photo), 1);
}

ImuSample Sample(std::int64_t ms, double rate) {
  return {Timestamp{ms * 1000000}, {0, 0, rate}, Vector3d::Zero()};
}

TEST(RotationBetweenTest, IntegratesTheRatesForthAndBack) {
  const std::deque<ImuSample> samples = {Sample(0, 1), Sample(5, 2), Sample(10, 4)};
  const auto angle = [&](std::int64_t from_ms, std::int64_t to_ms) {
    return LogSO3(
               RotationBetween(samples, Timestamp{from_ms * 1000000}, Timestamp{to_ms * 1000000}))
        .z();
  };
  EXPECT_NEAR(angle(0, 5), 0.005, 1e-12);
  EXPECT_NEAR(angle(3, 7), 0.002 + 0.004, 1e-12);
  EXPECT_NEAR(angle(7, 3), -0.006, 1e-12);
  EXPECT_NEAR(angle(8, 14), 0.004 + 0.016, 1e-12) << "the last rate goes on";
  EXPECT_NEAR(angle(-4, 1), 0.005, 1e-12) << "the first rate was there before";
  EXPECT_EQ(RotationBetween({}, Timestamp{0}, Timestamp{1}).w(), 1);
}

}  // namespace
}  // namespace facet
