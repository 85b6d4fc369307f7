// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/frame_geometry.h"

#include "facet/geometry/so3.h"

namespace facet {

namespace {

struct Mount {
  Matrix3d R_CB[2];
  Vector3d p_BC[2];
};

FrameGeometry::Pose MakePose(const Matrix3d (&R_CB)[2],
                             const Vector3d (&p_BC)[2],
                             const SE3& T_WB) {
  FrameGeometry::Pose pose;
  const Matrix3d R_WB = T_WB.R();
  pose.R_BW = R_WB.transpose();
  pose.p_WB = T_WB.p;
  for (int c = 0; c < 2; ++c) {
    pose.R_CW[c] = R_CB[c] * pose.R_BW;
    pose.p_WC[c] = T_WB.p + R_WB * p_BC[c];
  }
  pose.R_WC0 = pose.R_CW[0].transpose();
  pose.p_WC0 = pose.p_WC[0];
  return pose;
}

}  // namespace

FrameGeometry::FrameGeometry(const StereoRig& rig) : nominal_(rig) {
  for (std::size_t c = 0; c < 2; ++c) {
    R_CB[c] = rig.T_BC[c].R().transpose();
    p_BC[c] = rig.T_BC[c].p;
  }
}

void FrameGeometry::Update(const std::vector<WindowFrame>& frames) {
  current_.resize(frames.size());
  frozen_.resize(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    current_[i] = MakePose(R_CB, p_BC, frames[i].x.T_WB);
    frozen_[i] = frames[i].pose_frozen ? MakePose(R_CB, p_BC, frames[i].lin.T_WB) : current_[i];
  }
}

void FrameGeometry::Update(const SlidingWindow& window) {
  has_calibration_ = window.calibration.has_value();
  if (!has_calibration_) {
    Update(window.frames);
    return;
  }
  const WindowCalibration& calibration = *window.calibration;
  Mount nominal;
  nominal_ = calibration.nominal();
  delta_ = calibration.delta();
  modes_ = calibration.modes();
  estimates_modes_ = !calibration.are_modes_settled();
  for (int c = 0; c < 2; ++c) {
    const std::size_t i = static_cast<std::size_t>(c);
    present_lenses_[i] = PresentLens(nominal_.cameras[i],
                                     delta_.segment<kNumIntrinsics>(c * kNumIntrinsics),
                                     (*modes_)[i].Sum(calibration.LensModesAtPresent(c)));
    nominal.R_CB[c] = nominal_.T_BC[static_cast<std::size_t>(c)].R().transpose();
    nominal.p_BC[c] = nominal_.T_BC[static_cast<std::size_t>(c)].p;
    R_CB[c] = calibration.T_BC(c).R().transpose();
    p_BC[c] = calibration.T_BC(c).p;
  }
  current_.resize(window.frames.size());
  frozen_.resize(window.frames.size());
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    const WindowFrame& frame = window.frames[i];
    current_[i] = MakePose(R_CB, p_BC, calibration.AtImage(frame.x.T_WB, frame.Rates()));
    frozen_[i] =
        MakePose(nominal.R_CB, nominal.p_BC, frame.pose_frozen ? frame.lin.T_WB : frame.x.T_WB);
  }
}

SE3 FrameGeometry::AtImage(const SE3& T_WB, const BodyRates& rates) const {
  if (!has_calibration_) return T_WB;
  const double dt = delta_(kTimeOffset);
  return {(T_WB.q * ExpSO3(dt * rates.w_B)).normalized(), T_WB.p + T_WB.q * (dt * rates.v_B)};
}

Vector2d FrameGeometry::LensShift_px(const WindowObservation& observation, int camera) const {
  if (!has_calibration_) return Vector2d::Zero();
  return present_lens(camera).Shift(observation.rays[camera].bearing, observation.px[camera]);
}

Vector3d FrameGeometry::MeasuredBearing(const WindowObservation& observation, int camera) const {
  const MeasuredRay& ray = observation.rays[camera];
  if (!has_calibration_) return ray.bearing;
  const Matrix<2, 3> J_px_bearing = observation.sigma_px[camera] * ray.whitening;
  const Vector3d moved = AcrossRay(J_px_bearing) * LensShift_px(observation, camera);
  return (ray.bearing - moved).normalized();
}

}  // namespace facet
