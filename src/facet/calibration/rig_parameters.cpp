// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/rig_parameters.h"

#include "facet/geometry/so3.h"

namespace facet {
namespace {

Vector<kNumIntrinsics> ToVector(const CameraIntrinsics& k) {
  Vector<kNumIntrinsics> v;
  v << k.fx, k.fy, k.cx, k.cy, Vector4d(k.coefficients.data());
  return v;
}

CameraIntrinsics Change(CameraIntrinsics k, const Vector<kNumIntrinsics>& delta) {
  k.fx += delta(0);
  k.fy += delta(1);
  k.cx += delta(2);
  k.cy += delta(3);
  for (std::size_t i = 0; i < 4; ++i)
    k.coefficients[i] += delta(4 + static_cast<Eigen::Index>(i));
  return k;
}

}  // namespace

std::optional<StereoRig> ChangeParameters(const StereoRig& rig, const RigVector& delta) {
  StereoRig changed = rig;
  for (std::size_t c = 0; c < 2; ++c) {
    const auto first = static_cast<Eigen::Index>(c) * kNumIntrinsics;
    const CameraIntrinsics k =
        Change(rig.cameras[c].intrinsics(), delta.segment<kNumIntrinsics>(first));
    if (!CameraModel::WhatIsWrong(k).empty()) return std::nullopt;
    changed.cameras[c] = CameraModel(k);
  }
  const SE3 T_C1C0 =
      rig.T_C1C0().Retract(delta.segment<3>(kStereoRotation), delta.segment<3>(kStereoTranslation));
  changed.T_BC[1] = rig.T_BC[0] * T_C1C0.Inverse();
  return changed;
}

RigVector ParameterDifference(const StereoRig& from, const StereoRig& to) {
  RigVector delta;
  for (std::size_t c = 0; c < 2; ++c) {
    delta.segment<kNumIntrinsics>(static_cast<Eigen::Index>(c) * kNumIntrinsics) =
        ToVector(to.cameras[c].intrinsics()) - ToVector(from.cameras[c].intrinsics());
  }
  const SE3 a = from.T_C1C0(), b = to.T_C1C0();
  delta.segment<3>(kStereoRotation) = LogSO3(a.q.conjugate() * b.q);
  delta.segment<3>(kStereoTranslation) = b.p - a.p;
  return delta;
}

}  // namespace facet
