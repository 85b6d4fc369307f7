// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/window_step.h"

#include <algorithm>
#include <vector>

#include "facet/estimator/solver/landmark_elimination.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

// A landmark is never stepped nearer than this [1/m].
constexpr double kLargestInverseDistance = 20.0;

std::vector<SE3> HostPoses(const SlidingWindow& window) {
  std::vector<SE3> hosts(window.frames.size());
  for (std::size_t i = 0; i < window.frames.size(); ++i)
    hosts[i] = window.LeftCameraAt(static_cast<int>(i));
  return hosts;
}

// A landmark's step is a step in the world, relative to where the host was when it was linearised:
// equation (3.8), in the directions of its information.
void StepLandmark(const Vector3d& step,
                  const SE3& old_host,
                  const SlidingWindow& window,
                  WindowLandmark& landmark) {
  const SE3 new_host = window.LeftCameraAt(landmark.host);
  const double rho = std::clamp(landmark.inverse_distance + step.z(), 0.0, kLargestInverseDistance);
  const Vector3d bearing = landmark.bearing_H + landmark.information.basis_H * step.head<2>();
  const Vector3d y_W = old_host.q * bearing + rho * (old_host.p - new_host.p);
  const double norm = y_W.norm();
  landmark.bearing_H = new_host.q.conjugate() * (y_W / norm);
  landmark.inverse_distance = rho / norm;
}

}  // namespace

void ApplyStep(const LinearizedWindow& linear, const VectorXd& step, SlidingWindow& window) {
  const StateLayout& layout = linear.layout();
  const std::vector<SE3> old_hosts = HostPoses(window);
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    Vector<15> frame_step = Vector<15>::Zero();
    frame_step.head<6>() = step.segment<6>(layout.pose_column[i]);
    if (layout.motion_column[i] >= 0)
      frame_step.tail<9>() = step.segment<9>(layout.motion_column[i]);
    window.frames[i].ApplyStep(frame_step);
  }
  for (std::size_t k = 0; k < window.planes.size(); ++k)
    window.planes[k].ApplyStep(step.segment<3>(layout.plane_column[k]));
  VectorXd seen_step = step;
  if (layout.calibration_column >= 0) {
    window.calibration->ApplyStep(step.segment<kNumCalibration>(layout.calibration_column));
    seen_step = WithMountAsPoses(linear.mounts, layout, step);
  }
  for (int k = 0; k < linear.num_landmarks; ++k) {
    const LandmarkBlock& block = linear.landmarks[k];
    WindowLandmark& landmark = window.landmarks()[block.index];
    landmark.information = {
        block.V, TangentBasis(landmark.bearing_H), linear.loss_width, CountRows(landmark)};
    StepLandmark(
        BackSubstitute(block, layout, seen_step), old_hosts[landmark.host], window, landmark);
  }
}

}  // namespace facet
