// SPDX-License-Identifier: BSD-2-Clause
#include "run_recorder.h"

#include <utility>

#include "facet/regularities/report/plane_ids.h"

namespace facet {

FrameRecord MakeFrameRecord(const VioOutput& output) {
  FrameRecord f;
  f.t = output.t;
  f.is_keyframe = output.is_keyframe;
  f.has_pose = output.has_pose;
  f.segment = output.segment;
  f.state = output.state;
  f.T_MW = output.T_MW;
  f.is_in_map = output.is_in_map;
  f.sigma_p = output.sigma_p;
  f.sigma_theta = output.sigma_theta;
  f.sigma_v = output.sigma_v;
  f.sigma_b_g = output.sigma_b_g;
  f.sigma_b_a = output.sigma_b_a;
  f.status = ToString(output.status);
  f.reason = output.reason;
  f.times = output.times;
  f.num_landmarks = output.num_landmarks;
  f.num_planes = output.num_planes;
  f.num_constraints = output.num_constraints;
  return f;
}

void RunRecorder::Add(const VioOutput& output, const FrameCost& cost) {
  FrameRecord f = MakeFrameRecord(output);
  f.times[Stage::kDecode] += cost.decode_ms;
  f.wall_ms = cost.wall_ms;
  f.latency_ms = cost.latency_ms;
  f.pose_latency_ms = cost.pose_latency_ms;
  frames_.push_back(std::move(f));
  resets_.Add(output.t, output.was_reset ? 1 : 0);
  imu_gaps_.Add(output.t, output.imu_gaps);
  repeated_images_.Add(output.t, output.is_image_repeated ? 1 : 0);
  blank_images_.Add(output.t, output.is_image_blank ? 1 : 0);
  // As the estimator says it (estimator_result.cpp).
  const bool sees_little =
      output.status == TrackingStatus::kDegraded && output.reason == "few landmarks";
  few_landmarks_.Add(output.t, sees_little ? 1 : 0);
  for (const KeyframePose& k : output.finished_keyframes)
    keyframes_.push_back({k.t, k.T_WB});
  if (output.snapshot) last_snapshot_ = output.snapshot;
  if (output.mesh) AddMesh(output.mesh);
  if (output.has_pose && output.status != TrackingStatus::kLost) last_good_ = output.t;
}

void RunRecorder::AddMesh(const std::shared_ptr<const MeshSnapshot>& snapshot) {
  last_mesh_ = snapshot;
  const TriangleMesh& mesh = snapshot->mesh;
  double area_m2 = 0, view_area_m2 = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Vector3d& a = mesh.vertices[mesh.faces[f][0]];
    const Vector3d u = mesh.vertices[mesh.faces[f][1]] - a, v = mesh.vertices[mesh.faces[f][2]] - a;
    const double face_m2 = 0.5 * u.cross(v).norm();
    area_m2 += face_m2;
    if (snapshot->in_view[f] != 0) view_area_m2 += face_m2;
  }
  mesh_areas_m2_.push_back(area_m2);
  view_areas_m2_.push_back(view_area_m2);
}

void RunRecorder::Finish(const std::vector<KeyframePose>& window) {
  for (const KeyframePose& k : window)
    keyframes_.push_back({k.t, k.T_WB});
  SortByTime(keyframes_);
}

void RunRecorder::MoveInto(RunRecord& record) {
  record.frames = std::move(frames_);
  record.keyframes = std::move(keyframes_);
  record.num_resets = resets_.num;
  record.num_imu_gaps = imu_gaps_.num;
  if (last_mesh_) {
    record.mesh = MeshWithSigmas(*last_mesh_);
    if (record.planes) UseCurrentPlaneIds(*record.planes, record.mesh->plane_ids);
  }
  record.mesh_areas_m2 = std::move(mesh_areas_m2_);
  record.view_areas_m2 = std::move(view_areas_m2_);
  record.landmarks.clear();
  if (!last_snapshot_) return;
  for (const LandmarkEstimate& l : last_snapshot_->landmarks)
    record.landmarks.push_back(l.p_W);
}

}  // namespace facet
