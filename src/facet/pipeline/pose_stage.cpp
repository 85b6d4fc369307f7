// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/pose_stage.h"

#include <memory>
#include <utility>

#include "facet/estimator/factors/imu_factor.h"
#include "facet/pipeline/refusal.h"

namespace facet {

PoseStage::PoseStage(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options)
    : time_offset_(rig.time_offset),
      T_BC0_(rig.T_BC[0]),
      estimator_(rig, noise, options.estimator),
      check_calibration_(options.check_calibration),
      motion_check_(rig) {}

VioOutput PoseStage::Estimate(const TrackedFrame& frame) {
  VioOutput out;
  out.times = frame.times;
  if (frame.is_stray) {
    out.t = frame.frontend.observations.t;
    out.status =
        estimator_.is_initialised() ? TrackingStatus::kDegraded : TrackingStatus::kInitialising;
    out.reason = "stamp is far ahead of all others";
    return out;
  }
  EstimatorResult result = estimator_.AddFrame(frame.frontend.observations, frame.imu, out.times);
  const ScopedStage stage(out.times, Stage::kOutput);
  if (result.bias_drift && !result.bias_drift->is_gyro) motion_check_.DistrustAccelerometer();
  out.warning = frame.warning;
  const std::string of_estimate = JudgeCalibration(frame.frontend, result);
  if (out.warning.empty()) out.warning = of_estimate;
  FillPose(frame, std::move(result), out);
  if (check_calibration_) CheckMotion(frame, out);
  HandBack(out);
  return out;
}

// Before the start the window holds keyframes whose poses are nothing but the beginning of a
// search.
std::vector<KeyframePose> PoseStage::WindowKeyframes() const {
  if (!estimator_.is_initialised()) return {};
  return estimator_.Snapshot().keyframes;
}

void PoseStage::FillPose(const TrackedFrame& frame, EstimatorResult result, VioOutput& out) const {
  const FrameObservations& observations = frame.frontend.observations;
  out.frame = observations.frame;
  out.t = observations.t;
  out.is_keyframe = observations.is_keyframe;
  out.status = result.status;
  out.reason = result.reason;
  out.is_image_repeated = frame.frontend.is_repeated;
  out.is_image_blank = frame.frontend.is_blank;
  if (result.status == TrackingStatus::kDegraded) {
    if (frame.frontend.is_repeated) out.reason = "image repeated";
    if (frame.frontend.is_blank) out.reason = "image dark or without texture";
  }
  out.has_pose = result.has_state;
  out.segment = result.segment;
  out.state = result.state;
  out.causal = result.causal;
  out.covariance = result.covariance;
  out.solved_covariance = result.solved_covariance;
  if (result.has_state) {
    const Matrix<15, 15> of_size = size_doubt_.CovarianceOf(result.state);
    out.covariance += of_size;
    out.causal.covariance += of_size;
  }
  const Vector<15> sigma = out.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  out.sigma_theta = sigma.segment<3>(0);
  out.sigma_p = sigma.segment<3>(3);
  out.sigma_v = sigma.segment<3>(6);
  out.sigma_b_g = sigma.segment<3>(9);
  out.sigma_b_a = sigma.segment<3>(12);
  out.num_tracks = static_cast<int>(observations.features.size());
  out.num_landmarks = static_cast<int>(estimator_.window().landmarks().size());
  out.num_planes = static_cast<int>(estimator_.window().planes.size());
  out.num_constraints = estimator_.NumPlaneConstraints();
  out.imu_gaps = frame.imu.gaps;
  out.refusal = frame.refusal;
  out.was_reset = result.was_reset;
  out.finished_keyframes = std::move(result.finished_keyframes);
}

std::string PoseStage::JudgeCalibration(const FrontendResult& frontend,
                                        const EstimatorResult& result) {
  const FrameObservations& observations = frontend.observations;
  if (!observations.is_keyframe) return {};
  CalibrationEvidence evidence;
  evidence.t = observations.t;
  evidence.num_features = static_cast<int>(observations.features.size());
  if (frontend.right_ok) evidence.num_stereo = frontend.num_stereo;
  evidence.imu_error_sigma = result.imu_error_sigma;
  evidence.gross_deviations = estimator_.GrossDeviations();
  std::string warning = calibration_.Add(evidence);
  const auto& imu_error_sigma = result.imu_error_sigma;
  const bool contradicts = imu_error_sigma && *imu_error_sigma > kContradictionSigma;
  if (contradictions_.Begins(observations.t, contradicts) && warning.empty())
    warning = ContradictionWarning(*imu_error_sigma);
  if (warning.empty() && drifts_.Begins(observations.t, result.bias_drift.has_value()))
    warning = InWords(*result.bias_drift);
  return warning;
}

void PoseStage::CheckMotion(const TrackedFrame& frame, VioOutput& out) {
  motion_check_.AddImu(frame.imu);
  // Poses of before had another calibration, and so another size of the world.
  if (estimator_.calibration_freed_at() != size_since_) {
    size_since_ = estimator_.calibration_freed_at();
    motion_check_.WorldHasChanged();
    size_doubt_.WorldHasChanged();
  }
  const bool has_state = out.has_pose && !out.was_reset;
  if (!has_state) {
    motion_check_.LoseState();
    size_doubt_.LoseState();
  }
  if (!out.is_keyframe) return;
  const StereoRig* rig = estimator_.KeptRig();
  if (rig != nullptr && motion_check_.SetRig(*rig)) size_doubt_.WorldHasChanged();
  const NavState* state = has_state ? &estimator_.window().frames.back().x : nullptr;
  const ScaleCheck::Finding finding = motion_check_.AddKeyframe(frame.frontend.observations, state);
  if (has_state) size_doubt_.AddKeyframe(*state, motion_check_.scale(), motion_check_.turns());
  const ScaleCheck& found_by = motion_check_.found_by();
  if (finding == ScaleCheck::Finding::kDoubt) {
    waiting_warnings_.push_back(InWords(*found_by.scale()));
    estimator_.DoubtBaseline(found_by.scale()->value() - 1);
  } else if (finding == ScaleCheck::Finding::kRefusal && out.refusal.empty()) {
    out.refusal = kWrongCalibration + InWords(*found_by.scale());
  } else if (finding == ScaleCheck::Finding::kAxesTheOtherWay && out.refusal.empty()) {
    out.refusal = kWrongCalibration + NegatedAxesInWords(found_by.negated_axes());
  }
  // Lenses that have room are named by what is wrong with them.
  const auto turns = motion_check_.TakeDoubtOfTurns();
  if (turns && !estimator_.HaveLensesRoom()) waiting_warnings_.push_back(TurnsInWords(*turns));
  if (!waiting_warnings_.empty() && out.warning.empty()) {
    out.warning = std::move(waiting_warnings_.front());
    waiting_warnings_.pop_front();
  }
}

void PoseStage::HandBack(VioOutput& out) {
  feedback_.reset();
  if (out.is_keyframe && out.has_pose && !out.was_reset) {
    auto snapshot = std::make_shared<MapSnapshot>(estimator_.Snapshot());
    const bool is_freed = snapshot->rig && estimator_.calibration_freed_at();
    const SE3& T_BC0 = is_freed ? snapshot->rig->T_BC[0] : T_BC0_;
    feedback_ =
        Feedback{out.frame, false, snapshot->latest, snapshot->landmarks, T_BC0, snapshot->rig};
    feedback_->state.t = out.t + time_offset_;
    out.snapshot = std::move(snapshot);
  } else if (out.was_reset) {
    feedback_ = Feedback{out.frame, true, {}, {}, T_BC0_, nullptr};
    if (const StereoRig* kept = estimator_.KeptRig())
      feedback_->rig = std::make_shared<const StereoRig>(*kept);
  }
}

}  // namespace facet
