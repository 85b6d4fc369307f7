// SPDX-License-Identifier: BSD-2-Clause
// The part of VioEstimator that begins a run: collect frames until gravity and velocity are known,
// put them into the world, and keep them until they have said all they can (docs/window.md).
#include <algorithm>
#include <cmath>

#include "facet/estimator/start/initializer.h"
#include "facet/estimator/vio_estimator.h"
#include "facet/estimator/window/landmark_depth.h"
#include "facet/estimator/window/window_policy.h"
#include "facet/geometry/angles.h"

namespace facet {

namespace {

constexpr int kStartIterations = 25;
// Duplicates are kept up to this many frames: they average the pixel noise.
constexpr int kMinStartFrames = 8;
// Of a slow camera: velocity and gravity from positions need three.
constexpr int kFewestStartFrames = 4;
// A start needs gravity: at most this many intervals of its window may be without IMU.
constexpr int kMaxInventedIntervals = 1;
constexpr double kMaxDeadReckoning_s = 1.0;

bool HasInventedImu(const WindowFrame& frame) {
  return frame.imu_link && frame.imu_link->is_invented;
}

}  // namespace

EstimatorResult VioEstimator::Start(const FrameObservations& observations, StageTimes& times) {
  EstimatorResult result;
  ScopedStage stage(times, Stage::kOptimize);
  const bool has_imu = !HasInventedImu(window_.frames.back());
  AppendObservations(Prepare(observations), window_);
  DropUselessBeginning();
  geometry_.Update(window_.frames);
  InitializeDepths(geometry_, window_);

  const auto num_constraining =
      std::count_if(window_.landmarks().begin(), window_.landmarks().end(), IsConstraining);
  const int num_frames = static_cast<int>(window_.frames.size());
  const auto num_invented =
      std::count_if(window_.frames.begin(), window_.frames.end(), HasInventedImu);
  result.num_constraining = static_cast<int>(num_constraining);
  result.reason = has_imu ? "collecting frames" : "no IMU";
  if (!HasEnoughFramesToStart()) return result;
  if (num_invented > kMaxInventedIntervals) {
    result.reason = "too little IMU";
  } else if (num_constraining < options_.start.min_landmarks) {
    result.reason = "too few stereo landmarks";
  } else if (const auto start = InitializeFromStereo(rig_, options_, window_); !start.ok) {
    result.reason = start.reason;
  } else {
    solver_.Solve(window_, noise_, kStartIterations);
    RemoveOutliers();
    RelinearizeImu();
    result.solve = solver_.Solve(window_, noise_, kStartIterations);
    newest_covariance_ = solver_.NewestFrameCovariance();
    const double waited_s = ToSeconds(observations.t - first_t_);
    if (TiltSigma() < options_.start.max_tilt_deg * kDegree ||
        waited_s >= options_.start.max_wait_s) {
      MoveOriginToNewestFrame();
      // The covariance belongs to the origin and heading that were fixed when it was computed.
      solver_.Solve(window_, noise_, 1);
      newest_covariance_ = solver_.NewestFrameCovariance();
      initialised_ = true;
      FillResult(window_.frames.back(), NumSeenInNewest(), result);
      updater_.SetReference(window_, newest_covariance_, noise_);
      return result;
    }
    result.reason = "tilt not known well enough";
  }
  // The oldest frames may be what spoils the start (a blackout, a jump): let them go.
  if (num_frames >= 3 * options_.start.min_frames) {
    DropFirstFrame();
  }
  return result;
}

bool VioEstimator::HasEnoughFramesToStart() const {
  const int num_frames = static_cast<int>(window_.frames.size());
  const double span_s = ToSeconds(window_.frames.back().x.t - window_.frames.front().x.t);
  return num_frames >= options_.start.min_frames ||
         (num_frames >= kFewestStartFrames && span_s >= options_.start.enough_s);
}

void VioEstimator::DropUselessBeginning() {
  const auto is_dark = [this](int frame) {
    return std::none_of(
        window_.landmarks().begin(), window_.landmarks().end(), [&](const WindowLandmark& l) {
          return std::any_of(l.observations.begin(), l.observations.end(), [&](const auto& o) {
            return o.frame == frame;
          });
        });
  };
  while (window_.frames.size() > 1 && (HasInventedImu(window_.frames[1]) || is_dark(0)))
    DropFirstFrame();
}

void VioEstimator::DropFirstFrame() {
  window_.RemoveFrame(0);
  const WindowFrame& first = window_.frames.front();
  first_t_ = first.x.t;
  window_.start_prior->frame = first.id;
  window_.start_prior->T_WB = first.x.T_WB;
}

bool VioEstimator::EndStart(std::vector<KeyframePose>& finished) {
  if (start_is_over_) return true;
  if (!UpdateStart(finished)) return false;
  start_is_over_ = true;
  RelinearizeImu();
  solver_.Solve(window_, noise_, kStartIterations);
  return true;
}

bool VioEstimator::UpdateStart(std::vector<KeyframePose>& finished) {
  const double elapsed_s = ToSeconds(window_.frames.back().x.t - first_t_);
  if (elapsed_s < options_.window.start_s) return false;
  if (TiltSigma() < options_.window.start_tilt_deg * kDegree) return true;
  const int num_frames = static_cast<int>(window_.frames.size());
  if (num_frames <= kMinStartFrames) return false;
  // At rest the tilt stays uncertain, but the frames are duplicates: one of them goes without a
  // trace but for its IMU, which joins the next interval. In motion there is none, and the start
  // has to end.
  const int victim =
      MostRedundantFrame(window_, 1, num_frames - 3, options_.window.covisible_share);
  if (!IsDuplicate(window_, victim)) return num_frames > options_.window.max_start_keyframes;
  const WindowFrame& gone = window_.frames[victim];
  ImuLink joined = *window_.frames[victim + 1].imu_link;
  const std::vector<ImuSample> samples = joined.measured.samples();
  joined.measured = gone.imu_link->measured;
  joined.measured.Integrate(samples);
  UpdateSqrtInfo(joined);
  if (gone.is_reported) finished.push_back({gone.id, gone.x.t, gone.x.T_WB});
  window_.RemoveFrame(victim);
  window_.frames[victim].imu_link = std::move(joined);
  return false;
}

SE3 VioEstimator::StartPose() const {
  const SE3& newest = window_.frames.back().x.T_WB;
  if (!last_good_) {
    const Vector3d up_B = newest.q.conjugate() * Vector3d::UnitZ();
    return {RotationBetween(up_B, Vector3d::UnitZ()), Vector3d::Zero()};
  }
  // After a reset: go on from the last pose, with its heading and for a moment with its velocity.
  const double elapsed_s = ToSeconds(window_.frames.back().x.t - last_good_->t);
  const Quaterniond difference = last_good_->T_WB.q * newest.q.conjugate();
  const double yaw = 2 * std::atan2(difference.z(), difference.w());
  return {ExpSO3({0, 0, yaw}) * newest.q,
          last_good_->T_WB.p + std::min(elapsed_s, kMaxDeadReckoning_s) * last_good_->v_WB};
}

void VioEstimator::MoveOriginToNewestFrame() {
  const SE3 T_new_old = StartPose() * window_.frames.back().x.T_WB.Inverse();  // turns about z only
  for (WindowFrame& frame : window_.frames) {
    frame.x.T_WB = T_new_old * frame.x.T_WB;
    frame.x.T_WB.q.normalize();
    frame.x.v_WB = T_new_old.q * frame.x.v_WB;
    frame.lin = frame.x;
  }
  window_.start_prior->T_WB = window_.frames.front().x.T_WB;
}

double VioEstimator::TiltSigma() const {
  const Matrix3d R = window_.frames.back().x.T_WB.R();
  const Matrix3d cov_W = R * newest_covariance_.topLeftCorner<3, 3>() * R.transpose();
  return std::sqrt(std::max({cov_W(0, 0), cov_W(1, 1), 0.0}));
}

}  // namespace facet
