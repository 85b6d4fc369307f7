// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/back_stage.h"

#include <cmath>

#include "facet/regularities/plane_names.h"

namespace facet {

namespace {

bool PlanesJudgeFaces(const VioOptions& options) {
  return options.pipeline == "SPR" && options.regularities.faces.enabled;
}

}  // namespace

BackStage::BackStage(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options)
    : time_offset_(rig.time_offset),
      estimator_(rig, noise, options.estimator),
      mesh_(rig, options.mesh, PlanesJudgeFaces(options)),
      planes_judge_faces_(PlanesJudgeFaces(options)) {
  if (options.pipeline == "SPR") planes_.emplace(options.regularities);
  if (options.pipeline == "SP") projections_.emplace(options.regularities.detection);
}

VioOutput BackStage::Process(const FrontPacket& packet) {
  VioOutput out;
  out.times = packet.times;
  EstimatorResult result = estimator_.AddFrame(packet.frontend.observations, packet.imu, out.times);
  FillOutput(packet, std::move(result), out);
  if (out.was_reset) {
    mesh_.Reset();
    if (planes_) planes_->Reset();
    if (projections_) projections_->Reset();
  }
  if (out.snapshot) {
    std::shared_ptr<MeshSnapshot> mesh;
    {
      const ScopedStage stage(out.times, Stage::kMesh);
      mesh = mesh_.Process(packet.frontend.observations, packet.mesh, *out.snapshot);
    }
    if (mesh) FindRegularities(out, *mesh);
    out.mesh = std::move(mesh);
  }
  return out;
}

// Planes go from the mesh to the estimator as data; they come into force with the next keyframe.
void BackStage::FindRegularities(VioOutput& out, MeshSnapshot& mesh) {
  {
    const ScopedStage stage(out.times, Stage::kRegularities);
    if (projections_) estimator_.Assign(projections_->Process(mesh, *out.snapshot));
    if (!planes_) return;
    estimator_.Assign(planes_->Process(mesh, *out.snapshot));
  }
  const ScopedStage stage(out.times, Stage::kMesh);
  mesh_.SetFacePlanes(planes_->face_planes());
  if (!planes_->depth_scales().empty()) mesh_.SetDepthScales(planes_->depth_scales());
  if (planes_judge_faces_) {
    mesh_.JudgeBy([&](const auto& vertices, const auto& triangles) {
      return planes_->JudgeTriangles(vertices, triangles, out.snapshot->latest.T_WB);
    });
  }
  mesh = mesh_.Shown();
}

std::optional<TriangleMesh> BackStage::Map() const {
  std::optional<TriangleMesh> map = mesh_.Map();
  if (map && planes_) UseCurrentPlanes(planes_->Records(), map->plane_ids);
  return map;
}

std::vector<PlaneRecord> BackStage::Planes() const {
  return planes_ ? planes_->Records() : std::vector<PlaneRecord>();
}

std::string BackStage::JudgeCalibration(const FrontendResult& frontend,
                                        const EstimatorResult& result) {
  const FrameObservations& observations = frontend.observations;
  if (!observations.is_keyframe) return {};
  CalibrationEvidence evidence;
  evidence.t = observations.t;
  evidence.num_features = static_cast<int>(observations.features.size());
  if (frontend.right_ok) evidence.num_stereo = frontend.num_stereo;
  evidence.imu_error_sigma = result.imu_error_sigma;
  return calibration_.Add(evidence);
}

void BackStage::FillOutput(const FrontPacket& packet, EstimatorResult result, VioOutput& out) {
  const ScopedStage stage(out.times, Stage::kOutput);
  const FrameObservations& observations = packet.frontend.observations;
  out.frame = observations.frame;
  out.t = observations.t;
  out.is_keyframe = observations.is_keyframe;
  out.status = result.status;
  out.reason = result.reason;
  out.has_pose = result.has_state;
  out.state = result.state;
  const Vector<15> sigma = result.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  out.sigma_theta = sigma.segment<3>(0);
  out.sigma_p = sigma.segment<3>(3);
  out.sigma_v = sigma.segment<3>(6);
  out.sigma_b_g = sigma.segment<3>(9);
  out.sigma_b_a = sigma.segment<3>(12);
  out.warning = JudgeCalibration(packet.frontend, result);
  out.num_tracks = static_cast<int>(observations.features.size());
  out.num_landmarks = static_cast<int>(estimator_.window().landmarks().size());
  out.num_planes = static_cast<int>(estimator_.window().planes.size());
  out.num_constraints = estimator_.NumPlaneConstraints();
  out.imu_gaps = packet.imu.gaps;
  out.was_reset = result.was_reset;
  out.finished_keyframes = std::move(result.finished_keyframes);
  feedback_.reset();
  if (out.is_keyframe && out.has_pose && !out.was_reset) {
    auto snapshot = std::make_shared<MapSnapshot>(estimator_.Snapshot());
    feedback_ = Feedback{out.frame, false, snapshot->latest, snapshot->landmarks};
    feedback_->state.t = out.t + time_offset_;
    out.snapshot = std::move(snapshot);
  } else if (out.was_reset) {
    feedback_ = Feedback{out.frame, true, {}, {}};
  }
}

}  // namespace facet
