// SPDX-License-Identifier: BSD-2-Clause
// Images of a wall and a floor that are painted here, with the IMU of a body that sways before
// them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "facet/frontend/stereo_frontend.h"
#include "facet/geometry/se3.h"
#include "facet/imu/imu_types.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/frontend/synthetic_image.h"

namespace facet::testing {

inline constexpr Timestamp kBegin{1'400'000'000'000'000'000};
inline constexpr Duration kFrameInterval{50'000'000};
inline constexpr Duration kImuInterval{5'000'000};
inline constexpr Timestamp kEnd{kBegin.ns + 3'500'000'000};
inline constexpr double kWallX = 2.5, kFloorZ = -0.8;

inline constexpr double kTexel_m = 0.006;  // about a pixel

inline cv::Mat MakeTexture() {
  constexpr int kTexels = 1024;
  return Render(
      WaveTexture(1), kTexels, kTexels, [](double x, double y) { return Vector2d(x, y); });
}

/// A wall ahead and the floor, seen by one camera that does not turn.
class Painter {
 public:
  Painter(const CameraModel& camera, const Matrix3d& R_WC) {
    for (int row = 0; row < camera.height(); ++row) {
      for (int column = 0; column < camera.width(); ++column) {
        const auto ray_C = camera.Unproject({column, row});
        rays_W_.push_back(ray_C ? Vector3d(R_WC * *ray_C) : Vector3d::UnitX());
      }
    }
    u_.create(camera.height(), camera.width(), CV_32FC1);
    v_.create(camera.height(), camera.width(), CV_32FC1);
  }

  cv::Mat Paint(const Vector3d& p_WC, const cv::Mat& texture) {
    for (std::size_t i = 0; i < rays_W_.size(); ++i) {
      const Vector3d& ray = rays_W_[i];
      const double to_wall = (kWallX - p_WC.x()) / ray.x();
      const double to_floor = ray.z() < 0 ? (kFloorZ - p_WC.z()) / ray.z() : 1e9;
      const Vector3d p = p_WC + std::min(to_wall, to_floor) * ray;
      const double along = to_wall < to_floor ? p.z() : p.x() + 7;
      u_.ptr<float>()[i] = static_cast<float>(512 + p.y() / kTexel_m);
      v_.ptr<float>()[i] = static_cast<float>(512 + along / kTexel_m);
    }
    cv::Mat image;
    cv::remap(texture, image, u_, v_, cv::INTER_LINEAR, cv::BORDER_WRAP);
    return image;
  }

 private:
  std::vector<Vector3d> rays_W_;
  cv::Mat u_, v_;
};

/// The body sways without turning; its left camera looks along x.
struct Sway {
  static constexpr double kX = 0.15, kY = 0.3, kZ = 0.1;           // [m]
  static constexpr double kRateX = 1.3, kRateY = 2, kRateZ = 1.7;  // [rad/s]

  static Vector3d Position(double t) {
    return {kX * std::sin(kRateX * t), kY * std::sin(kRateY * t), kZ * std::sin(kRateZ * t)};
  }
  static Vector3d Acceleration(double t) {
    const Vector3d p = Position(t);
    return {-kRateX * kRateX * p.x(), -kRateY * kRateY * p.y(), -kRateZ * kRateZ * p.z()};
  }
};

struct PaintedRecording {
  StereoRig rig = EurocRig();
  std::vector<StereoFrame> frames;
  std::vector<ImuSample> imu;
  SE3 T_WB0;  // where the body is at first
};

inline PaintedRecording PaintRecording() {
  PaintedRecording out;
  Matrix3d R_WC0;
  R_WC0 << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Matrix3d R_WB = R_WC0 * out.rig.T_BC[0].R().transpose();
  out.T_WB0 = {Quaterniond(R_WB), Sway::Position(0)};
  const cv::Mat texture = MakeTexture();
  Painter left(out.rig.cameras[0], R_WC0);
  Painter right(out.rig.cameras[1], R_WB * out.rig.T_BC[1].R());
  for (Timestamp t = kBegin; t < kEnd; t = t + kFrameInterval) {
    const SE3 T_WB(out.T_WB0.q, Sway::Position(ToSeconds(t - kBegin)));
    out.frames.push_back({t,
                          left.Paint(T_WB * out.rig.T_BC[0].p, texture),
                          right.Paint(T_WB * out.rig.T_BC[1].p, texture)});
  }
  for (Timestamp t = kBegin; t <= kEnd; t = t + kImuInterval) {
    const Vector3d force_W =
        Sway::Acceleration(ToSeconds(t - kBegin)) + kGravity * Vector3d::UnitZ();
    out.imu.push_back({t, Vector3d::Zero(), R_WB.transpose() * force_W});
  }
  return out;
}

/// Calls add_imu and add_stereo in the order of time.
template <class AddImu, class AddStereo>
void Feed(const PaintedRecording& recording, const AddImu& add_imu, const AddStereo& add_stereo) {
  std::size_t next = 0;
  for (const StereoFrame& frame : recording.frames) {
    for (; next < recording.imu.size() && recording.imu[next].t <= frame.t + kImuInterval; ++next)
      add_imu(recording.imu[next]);
    add_stereo(frame);
  }
}

}  // namespace facet::testing
