// SPDX-License-Identifier: BSD-2-Clause
// The smallest use of Facet as a library: two cameras and an IMU at rest before a wall of random
// squares. Prints the pose of the last frame.
#include <cstdio>
#include <random>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "facet/pipeline/vio_pipeline.h"

namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr int kDisparity = 20;  // pixels; the wall is 2.2 m away
constexpr std::int64_t kFrameNs = 50'000'000, kImuNs = 5'000'000;

/// Cameras that look along the body's x axis, 11 cm apart, without distortion.
facet::StereoRig MakeRig() {
  facet::CameraIntrinsics k;
  k.width = kWidth;
  k.height = kHeight;
  k.fx = k.fy = 400;
  k.cx = 0.5 * kWidth;
  k.cy = 0.5 * kHeight;
  facet::Matrix3d R_BC;
  R_BC << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // x right, y down, z forward in the camera
  facet::StereoRig rig;
  for (std::size_t c = 0; c < 2; ++c) {
    rig.cameras[c] = facet::CameraModel(k);
    rig.T_BC[c] = {facet::Quaterniond(R_BC), facet::Vector3d(0, c == 0 ? 0.055 : -0.055, 0)};
  }
  return rig;
}

cv::Mat MakeWall() {
  constexpr int kSquare = 12;
  std::mt19937 random(1);
  cv::Mat wall(kHeight, kWidth + kDisparity, CV_8UC1);
  for (int y = 0; y < wall.rows; y += kSquare) {
    for (int x = 0; x < wall.cols; x += kSquare) {
      const cv::Rect square(x, y, kSquare, kSquare);
      wall(square & cv::Rect(0, 0, wall.cols, wall.rows)) = random() % 256;
    }
  }
  cv::GaussianBlur(wall, wall, cv::Size(5, 5), 1);  // as a lens does
  return wall;
}

}  // namespace

int main() {
  facet::VioPipeline vio(MakeRig(), facet::ImuNoise(), facet::VioOptions());
  const cv::Mat wall = MakeWall();
  const cv::Mat left = wall.colRange(0, kWidth).clone();
  const cv::Mat right = wall.colRange(kDisparity, kDisparity + kWidth).clone();
  facet::VioOutput out;
  std::int64_t imu_ns = 0;
  for (std::int64_t t_ns = 0; t_ns < 40 * kFrameNs; t_ns += kFrameNs) {
    for (; imu_ns <= t_ns + kImuNs; imu_ns += kImuNs)
      vio.AddImu({{imu_ns}, facet::Vector3d::Zero(), facet::Vector3d(0, 0, 9.81)});
    out = vio.AddStereo({{t_ns}, left, right});
  }
  if (!out.has_pose) {
    std::printf("no pose: %s\n", out.reason.c_str());
    return 1;
  }
  const facet::Vector3d p = out.state.T_WB.p;
  std::printf("%d landmarks, at %.4f %.4f %.4f m\n", out.num_landmarks, p.x(), p.y(), p.z());
  return p.norm() < 0.01 && out.num_landmarks > 20 ? 0 : 1;
}
