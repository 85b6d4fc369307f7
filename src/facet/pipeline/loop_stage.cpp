// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/loop_stage.h"

#include <algorithm>

namespace facet {

namespace {

/// Of a distance that is known from one stereo pair alone. Along the baseline none is known.
double StereoSigma_m(const StereoRig& rig, const FeatureObservation& feature, const Vector3d& p_C) {
  constexpr double kLeastSine = 0.1;
  const double match_px =
      feature.sigma_match_px > 0 ? feature.sigma_match_px : feature.sigma_right_px;
  const Vector3d along_C = rig.T_C1C0().Inverse().p.normalized();
  const double sine = std::max(along_C.cross(p_C.normalized()).norm(), kLeastSine);
  return p_C.squaredNorm() * match_px / (rig.cameras[0].mean_focal_px() * rig.baseline_m() * sine);
}

}  // namespace

LoopStage::LoopStage(const StereoRig& rig, const VioOptions& options)
    : rig_(rig), keeps_map_(options.keeps_map), known_map_(options.known_map) {
  if (!options.loops.enabled) return;
  if (options.known_map) {
    map_.emplace(rig, options.loops, *options.known_map);
  } else {
    map_.emplace(rig, options.loops);
  }
  num_known_places_ = map_->num_places();
  is_in_map_ = map_->is_localised();
}

void LoopStage::Correct(VioOutput& out) {
  while (!due_.empty() && due_.front().frame <= out.frame) {
    T_MW_ = due_.front().T_MW;
    is_in_map_ = due_.front().is_in_map;
    due_.pop_front();
  }
  out.T_MW = T_MW_;
  out.is_in_map = is_in_map_;
}

void LoopStage::Add(const cv::Mat& left, const TrackedFrame& frame, const VioOutput& out) {
  if (!map_) return;
  const double start_ms = ThreadCpuMs();
  for (const KeyframePose& keyframe : out.finished_keyframes)
    map_->Smooth(keyframe.id, keyframe.T_WB);
  const bool has_image = frame.frontend.image_ok;
  if (has_image && out.snapshot && map_->IsWanted(out.t)) {
    map_->Refine(*out.snapshot);
    const StereoRig& rig = out.snapshot->rig ? *out.snapshot->rig : rig_;
    view_.camera = rig.cameras[0];
    view_.T_BC = rig.T_BC[0];
    // Where the camera was when the image was taken.
    FillView(left, out.snapshot->T_WC0 * view_.T_BC.Inverse(), out);
    FillPoints(frame, *out.snapshot, rig);
    map_->Add(view_);
    Hand(out.frame);
  } else if (has_image && !out.snapshot && out.has_pose && map_->IsLookedFor(out.t)) {
    FillView(left, out.state.T_WB, out);  // with the camera of the last keyframe
    map_->Look(view_);
    Hand(out.frame);
  }
  cpu_ms_ += ThreadCpuMs() - start_ms;
}

void LoopStage::Hand(FrameId frame) {
  view_.left.release();  // whoever owns the pixels may use them again
  due_.push_back({FrameId{frame.value + kLag}, map_->T_MW().ToSE3(), map_->is_localised()});
}

void LoopStage::FillView(const cv::Mat& left, const SE3& T_WB, const VioOutput& out) {
  view_.frame = out.frame;
  view_.t = out.t;
  view_.segment = out.segment;
  view_.T_WB = T_WB;
  const Vector<15> sigma = out.solved_covariance.diagonal().cwiseMax(0).cwiseSqrt();
  view_.sigma_theta = sigma.segment<3>(0);
  view_.sigma_p = sigma.segment<3>(3);
  view_.left = left;
  view_.points.clear();
}

void LoopStage::FillPoints(const TrackedFrame& frame,
                           const MapSnapshot& snapshot,
                           const StereoRig& rig) {
  const SE3 T_CW = snapshot.T_WC0.Inverse();
  const auto& features = frame.frontend.observations.features;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (const LandmarkEstimate* landmark = FindLandmark(snapshot, features[i].landmark)) {
      view_.points.push_back({features[i].landmark,
                              features[i].px_left,
                              T_CW * landmark->p_W,
                              landmark->sigma_depth_m});
    } else if (const double rho = frame.frontend.depths.inverse_distances[i]; rho > 0) {
      const auto bearing = view_.camera.Unproject(features[i].px_left);
      if (!bearing) continue;
      const Vector3d p_C = *bearing / rho;
      view_.points.push_back(
          {features[i].landmark, features[i].px_left, p_C, StereoSigma_m(rig, features[i], p_C)});
    }
  }
}

std::optional<LoopResult> LoopStage::Result() const {
  if (!map_) return std::nullopt;
  constexpr double kBytesPerMb = 1024 * 1024;
  LoopResult result;
  result.corrections = map_->Corrections();
  result.closures = map_->Closures();
  result.num_places = map_->num_places();
  result.num_known_places = num_known_places_;
  result.has_known_map = num_known_places_ > 0;
  result.localised = map_->localised();
  result.is_ambiguous = map_->is_ambiguous();
  // Closures within a run that was not found move nothing in the map of runs before.
  if (keeps_map_ && map_->is_localised()) {
    result.map = std::make_shared<SavedMap>(map_->Saved());
  } else if (keeps_map_) {
    result.map = known_map_;
  }
  result.memory_mb = static_cast<double>(map_->memory_bytes()) / kBytesPerMb;
  result.cpu_ms = cpu_ms_;
  return result;
}

}  // namespace facet
