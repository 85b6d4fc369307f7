// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/front_stage.h"

#include <algorithm>
#include <cmath>

#include "facet/imu/preintegration.h"

namespace facet {

namespace {
// The newest image may come this much before the IMU sample that follows it.
constexpr double kMaxExtrapolation_s = 0.03;
constexpr double kMinDepth_m = 0.05;

std::uint8_t GreyValueAt(const cv::Mat& image, const Vector2d& px) {
  const int x = std::clamp(static_cast<int>(std::lround(px.x())), 0, image.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(px.y())), 0, image.rows - 1);
  return image.at<std::uint8_t>(y, x);
}
}  // namespace

FrontStage::FrontStage(const StereoRig& rig, const VioOptions& options)
    : rig_(rig),
      max_gap_s_(options.estimator.imu.max_gap_s),
      mesh_options_(options.mesh),
      frontend_(rig, options.frontend),
      support_places_(options.mesh.support) {}

ImuBuffer::AddResult FrontStage::AddImu(const ImuSample& sample) {
  const ImuBuffer::AddResult result = imu_.Add(sample);
  if (!has_previous_ && !imu_.empty()) imu_.DropBefore(imu_.last_stamp() - kLongestHistory);
  return result;
}

FrontPacket FrontStage::Process(const StereoFrame& frame) {
  FrontPacket packet;
  const Timestamp t_imu = frame.t + rig_.time_offset;
  FrontendHint hint;
  {
    ScopedStage stage(packet.times, Stage::kImu);
    TakeFeedback();
    packet.imu = IntervalTo(t_imu);
    hint = Predict(packet.imu);
  }
  packet.used_feedback = hint.inverse_depth != nullptr;
  packet.frontend = frontend_.Process(frame, hint, packet.times);
  if (packet.frontend.observations.is_keyframe && mesh_options_.enabled) {
    FillMeshPacket(frame, packet);
  }
  previous_t_ = t_imu;
  has_previous_ = true;
  ++next_frame_;
  ForgetOldImu();
  return packet;
}

// What is still needed: the time since the feedback in use, and since the frames whose feedback may
// yet come.
void FrontStage::ForgetOldImu() {
  recent_.push_back(previous_t_);
  if (static_cast<std::int64_t>(recent_.size()) > kLag) recent_.pop_front();
  Timestamp oldest = *std::min_element(recent_.begin(), recent_.end());
  for (const Feedback& feedback : feedback_) {
    if (!feedback.is_reset) oldest = std::min(oldest, feedback.state.t);
  }
  imu_.DropBefore(oldest);
}

void FrontStage::FillMeshPacket(const StereoFrame& frame, FrontPacket& packet) {
  const ScopedStage stage(packet.times, Stage::kMesh);
  const std::vector<FeatureObservation>& features = packet.frontend.observations.features;
  MeshPacket& mesh = packet.mesh;
  mesh.intensities.reserve(features.size());
  for (const FeatureObservation& feature : features)
    mesh.intensities.push_back(GreyValueAt(frame.left, feature.px_left));
  mesh.inverse_depths = packet.frontend.inverse_depths;
  if (!mesh_options_.support.enabled) return;
  const std::vector<DepthQuery>& places =
      support_places_.Choose(frame.left, features, packet.frontend.inverse_depths);
  mesh.support.reserve(places.size());
  frontend_.MatchDepths(places, mesh.support);
  mesh.support_intensities.reserve(mesh.support.size());
  for (const DepthPoint& point : mesh.support)
    mesh.support_intensities.push_back(GreyValueAt(frame.left, point.px));
}

void FrontStage::TakeFeedback() {
  const auto old_enough = [&](const Feedback& f) { return f.frame.value <= next_frame_ - kLag; };
  while (feedback_.size() >= 2 && old_enough(feedback_[1]))
    feedback_.pop_front();
  has_feedback_ =
      !feedback_.empty() && old_enough(feedback_.front()) && !feedback_.front().is_reset;
}

ImuInterval FrontStage::IntervalTo(Timestamp t_imu) const {
  if (imu_.empty()) return {};
  const Duration gap = FromSeconds(max_gap_s_), extrapolation = FromSeconds(kMaxExtrapolation_s);
  if (has_previous_) return imu_.Between(previous_t_, t_imu, gap, extrapolation);
  return imu_.Between(std::min(imu_.first_stamp(), t_imu), t_imu, gap, extrapolation);
}

FrontendHint FrontStage::Predict(const ImuInterval& now) {
  FrontendHint hint;
  if (!has_previous_ || imu_.empty()) return hint;
  const Duration gap = FromSeconds(max_gap_s_), extrapolation = FromSeconds(kMaxExtrapolation_s);
  ImuPreintegration motion(has_feedback_ ? feedback_.front().state.bias : ImuBias(),
                           PreintegrationNoise());
  motion.Integrate(now.samples);
  hint.R_prev_now = motion.dR();
  if (!has_feedback_) return hint;

  const Feedback& feedback = feedback_.front();
  const ImuInterval since = imu_.Between(feedback.state.t, previous_t_, gap, extrapolation);
  if (since.samples.empty()) return hint;
  ImuPreintegration to_previous(feedback.state.bias, PreintegrationNoise());
  to_previous.Integrate(since.samples);
  NavState previous = to_previous.Predict(feedback.state);
  previous.t = previous_t_;
  const NavState next = motion.Predict(previous);
  hint.p_prev_now = previous.T_WB.q.conjugate() * (next.T_WB.p - previous.T_WB.p);

  const SE3 T_C0W = (previous.T_WB * rig_.T_BC[0]).Inverse();
  inverse_depth_.clear();
  for (const LandmarkEstimate& landmark : feedback.landmarks) {
    const double z = (T_C0W * landmark.p_W).z();
    if (z > kMinDepth_m) inverse_depth_[landmark.id] = 1.0 / z;
  }
  hint.inverse_depth = &inverse_depth_;
  return hint;
}

}  // namespace facet
