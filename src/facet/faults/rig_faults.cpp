// SPDX-License-Identifier: BSD-2-Clause
// Of the calibration.
#include <utility>

#include "facet/faults/fault_kind.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

void TurnRight(const FaultValues& value, RecordingCopy& recording) {
  Vector3d turn = Vector3d::Zero();
  turn[static_cast<Eigen::Index>(value.at("axis"))] = value.at("deg") * kDegree;
  Quaterniond& q = recording.rig.T_BC[1].q;
  q = (q * ExpSO3(turn)).normalized();
}

void ScaleFocal(const FaultValues& value, RecordingCopy& recording) {
  for (CameraModel& camera : recording.rig.cameras) {
    CameraIntrinsics k = camera.intrinsics();
    k.fx *= 1 + value.at("percent") / 100;
    k.fy *= 1 + value.at("percent") / 100;
    camera = CameraModel(k);
  }
}

void ScaleBaseline(const FaultValues& value, RecordingCopy& recording) {
  auto& [left, right] = recording.rig.T_BC;
  right.p = left.p + (1 + value.at("percent") / 100) * (right.p - left.p);
}

void InvertExtrinsics(const FaultValues& /*value*/, RecordingCopy& recording) {
  for (SE3& T_BC : recording.rig.T_BC)
    T_BC = T_BC.Inverse();
}

void SwapCameras(const FaultValues& /*value*/, RecordingCopy& recording) {
  std::swap(recording.images[0], recording.images[1]);
}

/// Both cameras together against the IMU, about an axis of the body.
void TurnCameras(const FaultValues& value, RecordingCopy& recording) {
  Vector3d turn = Vector3d::Zero();
  turn[static_cast<Eigen::Index>(value.at("axis"))] = value.at("deg") * kDegree;
  const Quaterniond q = ExpSO3(turn);
  for (SE3& T_BC : recording.rig.T_BC)
    T_BC = SE3(q, Vector3d::Zero()) * T_BC;
}

/// As if nobody had calibrated cameras and IMU together.
void ForgetMount(const FaultValues& /*value*/, RecordingCopy& recording) {
  const SE3 T_C0B = recording.rig.T_BC[0].Inverse();
  for (SE3& T_BC : recording.rig.T_BC)
    T_BC = T_C0B * T_BC;
}

void FlattenLens(const FaultValues& value, RecordingCopy& recording) {
  for (CameraModel& camera : recording.rig.cameras) {
    CameraIntrinsics k = camera.intrinsics();
    for (double& coefficient : k.coefficients)
      coefficient *= 1 - value.at("share");
    camera = CameraModel(k);
  }
}

void ScaleDensities(const FaultValues& value, RecordingCopy& recording) {
  recording.imu_noise.gyro_noise *= value.at("gyro");
  recording.imu_noise.accel_noise *= value.at("accel");
}

}  // namespace

std::vector<FaultKind> RigFaults() {
  return {
      {"right_turned", {{"axis", 1}, {"deg", 0.2}}, "calibration: the right camera", TurnRight},
      {"focal", {{"percent", 1}}, "calibration: the focal lengths", ScaleFocal},
      {"baseline", {{"percent", 2}}, "calibration: the baseline", ScaleBaseline},
      {"inverted_T_BS", {}, "calibration: extrinsics the wrong way round", InvertExtrinsics},
      {"swapped", {}, "left images are the right ones", SwapCameras},
      {"cameras_turned",
       {{"axis", 0}, {"deg", 3}},
       "calibration: both cameras against the IMU",
       TurnCameras},
      {"identity_T_BS", {}, "calibration: the left camera's T_BS is the identity", ForgetMount},
      {"no_distortion", {{"share", 1}}, "calibration: this share of it is missing", FlattenLens},
      {"densities",
       {{"gyro", 100}, {"accel", 1}},
       "calibration: the IMU's noise densities times this",
       ScaleDensities},
  };
}

}  // namespace facet
