// SPDX-License-Identifier: BSD-2-Clause
// Stands in for the drivers of a robot: two cameras and an IMU at rest before a wall of random
// squares, by a clock that runs. A real driver has the same three functions.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <random>
#include <thread>
#include <vector>

#include "facet/facet.h"

class Sensors {
 public:
  static constexpr int kWidth = 640, kHeight = 480;
  static constexpr int kDisparity = 20;  // pixels; the wall is 2.2 m away

  static facet::api::Calibration Calibration() {
    facet::api::Calibration calibration;
    calibration.left = CameraAt(0.055);
    calibration.right = CameraAt(-0.055);
    return calibration;
  }

  /// Nanoseconds since the start, by the clock of both sensors.
  std::int64_t Now() const { return (Clock::now() - start_).count(); }

  /// Waits for the next sample; 200 of them in a second.
  facet::api::ImuSample NextImu() {
    imu_ns_ += 5'000'000;
    std::this_thread::sleep_until(start_ + std::chrono::nanoseconds(imu_ns_));
    return {imu_ns_, {{0, 0, 0}}, {{0, 0, 9.81}}};
  }

  struct Pair {
    std::int64_t t_ns;
    facet::api::Image left, right;
  };

  /// Waits for the next pair; 20 of them in a second.
  Pair NextPair() {
    pair_ns_ += 50'000'000;
    std::this_thread::sleep_until(start_ + std::chrono::nanoseconds(pair_ns_));
    return {pair_ns_, {left_.data(), kWidth, kHeight}, {right_.data(), kWidth, kHeight}};
  }

 private:
  using Clock = std::chrono::steady_clock;

  /// A camera that looks along the body's x axis, y_m to its left.
  static facet::api::Camera CameraAt(double y_m) {
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
  static std::vector<std::uint8_t> MakeWall(int first_column) {
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

  const Clock::time_point start_ = Clock::now();
  const std::vector<std::uint8_t> left_ = MakeWall(0), right_ = MakeWall(kDisparity);
  std::int64_t imu_ns_ = 0, pair_ns_ = 0;
};
