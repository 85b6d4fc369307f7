// SPDX-License-Identifier: BSD-2-Clause
#include "run_recorder.h"

#include <algorithm>
#include <utility>

namespace facet {

void RunRecorder::Add(const VioOutput& output, const FrameCost& cost) {
  FrameRecord f;
  f.t = output.t;
  f.is_keyframe = output.is_keyframe;
  f.has_pose = output.has_pose;
  f.state = output.state;
  f.sigma_p = output.sigma_p;
  f.sigma_theta = output.sigma_theta;
  f.sigma_v = output.sigma_v;
  f.status = ToString(output.status);
  f.reason = output.reason;
  f.times = output.times;
  f.times[Stage::kDecode] += cost.decode_ms;
  f.wall_ms = cost.wall_ms;
  f.latency_ms = cost.latency_ms;
  f.num_landmarks = output.num_landmarks;
  frames_.push_back(f);
  num_resets_ += output.was_reset ? 1 : 0;
  num_imu_gaps_ += output.imu_gaps;
  for (const KeyframePose& k : output.finished_keyframes)
    keyframes_.push_back({k.t, k.T_WB});
  if (output.snapshot) last_snapshot_ = output.snapshot;
  if (output.has_pose && output.status != TrackingStatus::kLost) last_good_ = output.t;
}

void RunRecorder::Finish(const std::vector<KeyframePose>& window) {
  for (const KeyframePose& k : window)
    keyframes_.push_back({k.t, k.T_WB});
  const auto earlier = [](const StampedPose& a, const StampedPose& b) { return a.t < b.t; };
  const auto same = [](const StampedPose& a, const StampedPose& b) { return a.t == b.t; };
  std::stable_sort(keyframes_.begin(), keyframes_.end(), earlier);
  keyframes_.erase(std::unique(keyframes_.begin(), keyframes_.end(), same), keyframes_.end());
}

void RunRecorder::MoveInto(RunRecord& record) {
  record.frames = std::move(frames_);
  record.keyframes = std::move(keyframes_);
  record.num_resets = num_resets_;
  record.num_imu_gaps = num_imu_gaps_;
  record.landmarks.clear();
  if (!last_snapshot_) return;
  for (const LandmarkEstimate& l : last_snapshot_->landmarks)
    record.landmarks.push_back(l.p_W);
}

}  // namespace facet
