// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/frame_geometry.h"

namespace facet {

namespace {

FrameGeometry::Pose MakePose(const FrameGeometry& geometry, const SE3& T_WB) {
  FrameGeometry::Pose pose;
  const Matrix3d R_WB = T_WB.R();
  pose.R_BW = R_WB.transpose();
  pose.p_WB = T_WB.p;
  for (int c = 0; c < 2; ++c) {
    pose.R_CW[c] = geometry.R_CB[c] * pose.R_BW;
    pose.p_WC[c] = T_WB.p + R_WB * geometry.p_BC[c];
  }
  pose.R_WC0 = pose.R_CW[0].transpose();
  pose.p_WC0 = pose.p_WC[0];
  return pose;
}

}  // namespace

FrameGeometry::FrameGeometry(const StereoRig& rig) {
  for (int c = 0; c < 2; ++c) {
    R_CB[c] = rig.T_BC[c].R().transpose();
    p_BC[c] = rig.T_BC[c].p;
  }
}

void FrameGeometry::Update(const std::vector<WindowFrame>& frames) {
  current_.resize(frames.size());
  frozen_.resize(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    current_[i] = MakePose(*this, frames[i].x.T_WB);
    frozen_[i] = frames[i].pose_frozen ? MakePose(*this, frames[i].lin.T_WB) : current_[i];
  }
}

}  // namespace facet
