// SPDX-License-Identifier: BSD-2-Clause
// The axes of the accelerometer against those of the gyroscope: turned back by the gyroscope,
// gravity must stay where it is.
#include <algorithm>
#include <array>
#include <cmath>

#include "facet/check/detectors.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

// Means over parts of a window are compared with each other. Longer windows let the gyroscope
// drift, shorter parts let the motion through.
constexpr double kPart_s = 0.5;
constexpr int kPartsOfWindow = 8;
constexpr double kHole_s = 0.1;
constexpr std::size_t kMostSamples = 60000;
// How much steadier gravity must be with other axes: overall, and in most of the windows.
constexpr double kSteadier = 2.2, kShareOfWindows = 0.75;
constexpr int kMinWindows = 3;
// And how unsteady it is with these [m/s^2].
constexpr double kUnsteady = 1.5;

struct Axes {
  std::array<int, 3> axis;  // accelerometer k measures along this axis of the gyroscope
  std::array<int, 3> sign;
};

std::vector<Axes> AllAxes() {
  std::vector<Axes> all;
  std::array<int, 3> axis = {0, 1, 2};
  do {
    // All signs the other way is the same direction of gravity, reversed: it cannot be told.
    for (int signs = 0; signs < 4; ++signs)
      all.push_back({axis, {1, (signs & 1) != 0 ? -1 : 1, (signs & 2) != 0 ? -1 : 1}});
  } while (std::ranges::next_permutation(axis).found);
  return all;
}

/// Forces of each accelerometer as if it measured along each axis of the body, turned back.
struct Part {
  std::array<std::array<Vector3d, 3>, 3> sum{};  // by accelerometer, by axis
  double duration_s = 0;

  Vector3d Mean(const Axes& axes) const {
    Vector3d mean = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      mean += axes.sign[k] * sum[k][static_cast<std::size_t>(axes.axis[k])];
    return mean / duration_s;
  }
};

using Window = std::vector<Part>;

/// Mean square of how far gravity moves within the window.
double Unsteadiness(const Window& window, const Axes& axes) {
  Vector3d mean = Vector3d::Zero();
  double squares = 0;
  for (const Part& part : window) {
    const Vector3d force = part.Mean(axes);
    mean += force;
    squares += force.squaredNorm();
  }
  const double num = static_cast<double>(window.size());
  return std::max(0.0, squares / num - (mean / num).squaredNorm());
}

class AccelerometerAxes : public Detector {
 public:
  void OnImu(const ImuSample& sample) override {
    if (samples_.size() < kMostSamples) samples_.push_back(sample);
  }

  void Finish(CheckReport& report) override {
    if (report.is_gyroscope_wrong || !report.gyro_bias) {
      report.unchecked.push_back({"accel_axes", "images and gyroscope do not agree first"});
      return;
    }
    const std::vector<Window> windows = Windows(*report.gyro_bias);
    if (static_cast<int>(windows.size()) < kMinWindows) {
      report.unchecked.push_back({"accel_axes", "the IMU is too short"});
      return;
    }
    Judge(windows, report);
  }

 private:
  std::vector<Window> Windows(const Vector3d& bias) const {
    std::vector<Window> windows;
    Window window;
    Part part;
    Quaterniond R = Quaterniond::Identity();
    const auto begin = [&] {
      window.clear();
      part = Part();
      R.setIdentity();
    };
    for (auto& by_axis : part.sum)
      by_axis.fill(Vector3d::Zero());
    const Part empty = part;
    for (std::size_t i = 1; i < samples_.size(); ++i) {
      const ImuSample &a = samples_[i - 1], &b = samples_[i];
      const double dt_s = ToSeconds(b.t - a.t);
      if (dt_s > kHole_s) {
        begin();
        part = empty;
        continue;
      }
      R = R * ExpSO3(dt_s * (0.5 * (a.gyro + b.gyro) - bias));
      const Matrix3d M = R.toRotationMatrix();
      for (int k = 0; k < 3; ++k) {
        for (int axis = 0; axis < 3; ++axis)
          part.sum[static_cast<std::size_t>(k)][static_cast<std::size_t>(axis)] +=
              dt_s * b.accel[k] * M.col(axis);
      }
      part.duration_s += dt_s;
      if (part.duration_s < kPart_s) continue;
      window.push_back(part);
      part = empty;
      if (window.size() < kPartsOfWindow) continue;
      windows.push_back(window);
      begin();
      part = empty;
    }
    return windows;
  }

  static void Judge(const std::vector<Window>& windows, CheckReport& report) {
    const std::vector<Axes> all = AllAxes();
    const auto total = [&](const Axes& axes) {
      double sum = 0;
      for (const Window& window : windows)
        sum += Unsteadiness(window, axes);
      return sum / static_cast<double>(windows.size());
    };
    const double as_given = total(all.front());
    const Axes& best = *std::ranges::min_element(all, {}, total);
    const auto is_steadier = [&](const Window& window) {
      return Unsteadiness(window, best) < Unsteadiness(window, all.front());
    };
    const double share = static_cast<double>(std::ranges::count_if(windows, is_steadier)) /
                         static_cast<double>(windows.size());
    report.measured.push_back(
        Text("gravity, turned back by the gyroscope, moves by %.2f m/s^2, by "
             "%.2f m/s^2 with the best axes of the accelerometer",
             std::sqrt(as_given),
             std::sqrt(total(best))));
    if (as_given < kUnsteady * kUnsteady || as_given < kSteadier * total(best) ||
        share < kShareOfWindows) {
      return;
    }
    std::string words;
    constexpr std::array kNames = {"x", "y", "z"};
    for (std::size_t k = 0; k < 3; ++k) {
      words += Text("%s%s was %s%s",
                    k == 0 ? "" : ", ",
                    kNames[static_cast<std::size_t>(best.axis[k])],
                    best.sign[k] < 0 ? "-" : "",
                    kNames[k]);
    }
    report.Add({"accel_axes",
                Sureness::kLikely,
                Text("turned back by the gyroscope, gravity moves by %.1f m/s^2, but only by %.1f "
                     "m/s^2 if the axes of the accelerometer are taken otherwise (%s, or all of "
                     "them negated)",
                     std::sqrt(as_given),
                     std::sqrt(total(best)),
                     words.c_str()),
                "give accelerometer and gyroscope the same axes"});
  }

  std::vector<ImuSample> samples_;  // of the beginning
};

}  // namespace

std::unique_ptr<Detector> MakeAccelerometerAxes() {
  return std::make_unique<AccelerometerAxes>();
}

}  // namespace facet
