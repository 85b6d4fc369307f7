// SPDX-License-Identifier: BSD-2-Clause
#include "tracker.h"

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "facet/facet.h"

static_assert(__cplusplus < 202002L, "facet/facet.h is for C++17");

namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr int kDisparity = 20;  // pixels; the wall is 2.2 m away
constexpr std::int64_t kFrameNs = 50000000, kImuNs = 5000000;

/// A camera that looks along the body's x axis, y_m to its left.
facet::api::Camera CameraAt(double y_m) {
  facet::api::Camera camera;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.fx = camera.fy = 400;
  camera.cx = 0.5 * kWidth;
  camera.cy = 0.5 * kHeight;
  camera.T_BC.p = {{0, y_m, 0}};
  camera.T_BC.q = {{0.5, -0.5, 0.5, -0.5}};  // x right, y down, z forward in the camera
  return camera;
}

/// Random squares, their borders as soft as a lens makes them.
std::vector<std::uint8_t> MakeWall(int first_column) {
  constexpr int kSquare = 12, kSoft = 4, kColumns = kWidth / kSquare + 4;
  std::vector<double> squares(kColumns * (kHeight / kSquare + 2));
  std::mt19937 random(1);
  for (double& square : squares)
    square = static_cast<double>(random() % 256);
  const auto at = [&](int column, int row) {
    return squares[static_cast<std::size_t>(row * kColumns + column)];
  };
  const auto share_of_next = [](int place) {
    return std::max(0, place % kSquare - (kSquare - kSoft)) / static_cast<double>(kSoft);
  };
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = first_column; x < first_column + kWidth; ++x) {
      const int column = x / kSquare, row = y / kSquare;
      const double u = share_of_next(x), v = share_of_next(y);
      pixels.push_back(static_cast<std::uint8_t>(
          (1 - v) * ((1 - u) * at(column, row) + u * at(column + 1, row)) +
          v * ((1 - u) * at(column, row + 1) + u * at(column + 1, row + 1))));
    }
  }
  return pixels;
}

}  // namespace

TrackedPosition TrackAtRest() {
  facet::api::Calibration calibration;
  calibration.left = CameraAt(0.055);
  calibration.right = CameraAt(-0.055);
  facet::api::Odometry::Options options;
  options.overrides = {"mesh.map.enabled=false"};
  facet::api::Odometry odometry(calibration, options);
  TrackedPosition out;
  odometry.OnPose([&](const facet::api::State&) { ++out.num_calls; });
  const std::vector<std::uint8_t> left = MakeWall(0), right = MakeWall(kDisparity);
  facet::api::State state;
  std::int64_t imu_ns = 0;
  for (std::int64_t t_ns = 0; t_ns < 40 * kFrameNs; t_ns += kFrameNs) {
    for (; imu_ns <= t_ns + kImuNs; imu_ns += kImuNs)
      odometry.AddImu({imu_ns, {{0, 0, 0}}, {{0, 0, 9.81}}});
    state =
        odometry.AddStereo(t_ns, {left.data(), kWidth, kHeight}, {right.data(), kWidth, kHeight});
  }
  out.is_known = state.has_pose;
  out.x = state.T_WB.p[0];
  out.y = state.T_WB.p[1];
  out.z = state.T_WB.p[2];
  return out;
}
