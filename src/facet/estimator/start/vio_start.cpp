// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/start/vio_start.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "facet/estimator/factors/imu_factor.h"
#include "facet/estimator/start/initializer.h"
#include "facet/estimator/window/landmark_depth.h"
#include "facet/estimator/window/window_policy.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

constexpr int kStartIterations = 25;
// Duplicates are kept up to this many frames: they average the pixel noise.
constexpr int kMinStartFrames = 8;
// A slow camera brings few frames; velocity and gravity from positions need at least three.
constexpr int kFewestStartFrames = 4;
// Fewer frames than min_frames are enough when they span this time: what gravity and velocity do
// grows with time, not with the number of frames.
constexpr double kEnoughSpan_s = 0.28;
// A start needs gravity: at most this many intervals of its window may be without IMU.
constexpr int kMaxSyntheticIntervals = 1;
// A glitch of the IMU and images that stand still pass; an IMU or a calibration that is wrong does
// not, and what refuses those needs a state to judge.
constexpr double kMaxDoubt_s = 2;
// Simulated flights with a recorded IMU, whose truth is not exactly what it felt, begin with up to
// 10 sigma: what is less is waited for as long as the first pose is there within half a second.
constexpr double kGrossSigma = 10, kMaxSmallDoubt_s = 0.15;
// How far the gyroscope and the images alone may be apart between two frames [rad], and the largest
// bias of a gyroscope [rad/s]. Where they are further apart, a solution with both gives up either.
constexpr double kMaxTurnError = 0.01;
constexpr double kMaxGyroBias = 0.3;

constexpr const char* kDoubt = "IMU and images contradict each other";

bool HasSyntheticImu(const WindowFrame& frame) {
  return frame.imu_link && frame.imu_link->is_synthetic;
}

double SpanOf(const SlidingWindow& window) {
  return ToSeconds(window.frames.back().x.t - window.frames.front().x.t);
}

bool IsDark(int frame, const SlidingWindow& window) {
  const auto is_there = [&](const WindowObservation& o) { return o.frame == frame; };
  return std::none_of(
      window.landmarks().begin(), window.landmarks().end(), [&](const WindowLandmark& l) {
        return std::any_of(l.observations.begin(), l.observations.end(), is_there);
      });
}

void DropFirstFrame(SlidingWindow& window) {
  window.RemoveFrame(0);
  const WindowFrame& first = window.frames.front();
  window.start_prior->frame = first.id;
  window.start_prior->T_WB = first.x.T_WB;
}

// Frames at the beginning that say nothing of the others: dark ones, or without IMU after them.
void DropUselessBeginning(SlidingWindow& window) {
  while (window.frames.size() > 1 && (HasSyntheticImu(window.frames[1]) || IsDark(0, window)))
    DropFirstFrame(window);
}

// The largest `error(link, begin, end)` of all intervals with an IMU.
template <class Error>
double LargestOfIntervals(const SlidingWindow& window, const Error& error) {
  double largest = 0;
  for (std::size_t j = 1; j < window.frames.size(); ++j) {
    const std::optional<ImuLink>& link = window.frames[j].imu_link;
    if (!link || link->is_synthetic) continue;
    largest = std::max(largest, error(*link, window.frames[j - 1].x, window.frames[j].x));
  }
  return largest;
}

// With the first values, whose directions are those of the images alone.
bool DoesGyroscopeAgree(const SlidingWindow& window) {
  if (window.frames.back().x.bias.b_g.norm() > kMaxGyroBias) return false;
  const double turn = LargestOfIntervals(
      window, [&](const ImuLink& link, const NavState& begin, const NavState& end) {
        return ImuError(link.measured, begin, end, window.GyroScale()).head<3>().norm();
      });
  return turn < kMaxTurnError;
}

// How far the IMU and the solution are apart, in sigmas.
double ImuDisagreement(const SlidingWindow& window) {
  return LargestOfIntervals(window,
                            [&](const ImuLink& link, const NavState& begin, const NavState& end) {
                              return ImuErrorSigma(link, begin, end, window.GyroScale());
                            });
}

// Whether waiting may mend it.
bool IsWorthWaiting(double disagreement, double doubted_s) {
  if (disagreement < kContradictionSigma) return false;
  return doubted_s < (disagreement < kGrossSigma ? kMaxSmallDoubt_s : kMaxDoubt_s);
}

// 1-sigma of roll or pitch of the newest frame, whichever is larger [rad].
double TiltSigma(const Matrix<15, 15>& covariance, const SlidingWindow& window) {
  const Matrix3d R = window.frames.back().x.T_WB.R();
  const Matrix3d cov_W = R * covariance.topLeftCorner<3, 3>() * R.transpose();
  return std::sqrt(std::max({cov_W(0, 0), cov_W(1, 1), 0.0}));
}

// Where the newest frame is put in the world when the start succeeds.
SE3 StartPose(const NavState& newest, const std::optional<SE3>& predicted) {
  if (!predicted) {
    const Vector3d up_B = newest.T_WB.q.conjugate() * Vector3d::UnitZ();
    return {RotationBetween(up_B, Vector3d::UnitZ()), Vector3d::Zero()};
  }
  // The tilt is the start's own, which gravity tells.
  const Quaterniond difference = predicted->q * newest.T_WB.q.conjugate();
  const double yaw = 2 * std::atan2(difference.z(), difference.w());
  return {ExpSO3({0, 0, yaw}) * newest.T_WB.q, predicted->p};
}

// Turns everything about the vertical and moves it.
void MoveNewestFrameTo(const SE3& T_WB, SlidingWindow& window) {
  const SE3 T_new_old = T_WB * window.frames.back().x.T_WB.Inverse();
  for (WindowFrame& frame : window.frames) {
    frame.x.T_WB = T_new_old * frame.x.T_WB;
    frame.x.T_WB.q.normalize();
    frame.x.v_WB = T_new_old.q * frame.x.v_WB;
    frame.lin = frame.x;
  }
  window.start_prior->T_WB = window.frames.front().x.T_WB;
}

// A duplicate frame goes without a trace but for its IMU, which joins the next interval.
void RemoveDuplicate(int index,
                     const ImuIntervals& imu,
                     SlidingWindow& window,
                     std::vector<KeyframePose>& finished) {
  const WindowFrame& frame = window.frames[index];
  if (frame.is_reported) finished.push_back({frame.id, frame.x.t, frame.x.T_WB});
  ImuLink joined = imu.Join(*frame.imu_link, *window.frames[index + 1].imu_link);
  window.RemoveFrame(index);
  window.frames[index].imu_link = std::move(joined);
}

}  // namespace

void VioStart::AppendFirstFrame(WindowFrame frame,
                                const ImuInterval& imu,
                                const StartOptions& options,
                                SlidingWindow& window) {
  Vector3d mean = Vector3d::Zero();
  for (const ImuSample& sample : imu.samples)
    mean += sample.accel;
  if (mean.norm() > 1.0) frame.x.T_WB.q = RotationBetween(mean, Vector3d::UnitZ());
  frame.lin = frame.x;
  window.start_prior.emplace(frame.id, frame.x.T_WB, options);
  window.frames.push_back(std::move(frame));
}

StartAttempt VioStart::Try(const std::optional<SE3>& predicted,
                           const ImuIntervals& imu,
                           WindowOptimizer& optimizer,
                           SlidingWindow& window) {
  StartAttempt attempt;
  attempt.reason = HasSyntheticImu(window.frames.back()) ? "no IMU" : "collecting frames";
  DropUselessBeginning(window);
  InitializeDepths(optimizer.UpdateGeometry(window), window);
  attempt.num_constraining = static_cast<int>(
      std::count_if(window.landmarks().begin(), window.landmarks().end(), IsConstraining));
  const bool is_dark = IsDark(static_cast<int>(window.frames.size()) - 1, window);
  if (!is_dark && HasEnoughFrames(window)) TryFrames(predicted, imu, optimizer, window, attempt);
  // The oldest frames may be what spoils the start (a blackout, a jump): let them go.
  const int num_frames = static_cast<int>(window.frames.size());
  if (!attempt.has_started && num_frames >= 3 * options_.start.min_frames) DropFirstFrame(window);
  return attempt;
}

void VioStart::TryFrames(const std::optional<SE3>& predicted,
                         const ImuIntervals& imu,
                         WindowOptimizer& optimizer,
                         SlidingWindow& window,
                         StartAttempt& attempt) {
  if (!first_try_) first_try_ = window.frames.back().x.t;
  attempt.reason = FindFirstValues(attempt.num_constraining, window);
  // A start has no earlier states that would say what is wrong: better one a little later.
  const double doubted_s = ToSeconds(window.frames.back().x.t - *first_try_);
  if (attempt.reason.empty() && doubted_s < kMaxDoubt_s && !DoesGyroscopeAgree(window))
    attempt.reason = kDoubt;
  if (!attempt.reason.empty()) return;
  Solve(imu, optimizer, window, attempt);
  attempt.reason = WhyNotYet(attempt.covariance, doubted_s, window);
  if (attempt.reason.empty()) Begin(predicted, optimizer, window, attempt);
}

// With a solution; empty if nothing speaks against it. `covariance`: of the newest frame.
std::string VioStart::WhyNotYet(const Matrix<15, 15>& covariance,
                                double doubted_s,
                                const SlidingWindow& window) const {
  if (IsWorthWaiting(ImuDisagreement(window), doubted_s)) return kDoubt;
  if (!(TiltSigma(covariance, window) < options_.start.max_tilt_deg * kDegree) &&
      SpanOf(window) < options_.start.max_wait_s) {
    return "tilt not known well enough";
  }
  return {};
}

void VioStart::Begin(const std::optional<SE3>& predicted,
                     WindowOptimizer& optimizer,
                     SlidingWindow& window,
                     StartAttempt& attempt) {
  MoveNewestFrameTo(StartPose(window.frames.back().x, predicted), window);
  // The covariance belongs to the origin and heading that were fixed when it was computed.
  optimizer.Solve(window, 1);
  attempt.covariance = optimizer.solver().NewestFrameCovariance();
  // Of measurements that contradict each other as much as numbers can.
  attempt.has_failed = !attempt.covariance.allFinite();
  if (attempt.has_failed) attempt.reason = "numerical failure";
  attempt.has_started = has_state_ = !attempt.has_failed;
}

// Dark frames, or those whose image was seen before, are none.
bool VioStart::HasEnoughFrames(const SlidingWindow& window) const {
  int num_frames = 0;
  for (int i = 0; i < static_cast<int>(window.frames.size()); ++i)
    num_frames += IsDark(i, window) ? 0 : 1;
  return num_frames >= options_.start.min_frames ||
         (num_frames >= kFewestStartFrames && SpanOf(window) >= kEnoughSpan_s);
}

// First values of all states; if there are none, why not.
std::string VioStart::FindFirstValues(int num_constraining, SlidingWindow& window) const {
  if (std::count_if(window.frames.begin(), window.frames.end(), HasSyntheticImu) >
      kMaxSyntheticIntervals) {
    return "too little IMU";
  }
  if (num_constraining < options_.start.min_landmarks) return "too few stereo landmarks";
  return InitializeFromStereo(rig_, options_, window).reason;
}

void VioStart::Solve(const ImuIntervals& imu,
                     WindowOptimizer& optimizer,
                     SlidingWindow& window,
                     StartAttempt& attempt) const {
  optimizer.Solve(window, kStartIterations);
  optimizer.LearnFrom(optimizer.RemoveOutliers(window));
  imu.Relinearize(window);
  attempt.solve = optimizer.Solve(window, kStartIterations);
  attempt.covariance = optimizer.solver().NewestFrameCovariance();
}

bool VioStart::EndIfDue(const Matrix<15, 15>& covariance,
                        const ImuIntervals& imu,
                        WindowOptimizer& optimizer,
                        SlidingWindow& window,
                        std::vector<KeyframePose>& finished) {
  if (is_over_) return true;
  if (!ShouldEnd(covariance, imu, window, finished)) return false;
  is_over_ = true;
  imu.Relinearize(window);
  optimizer.Solve(window, kStartIterations);
  return true;
}

// At rest the tilt stays uncertain, but the frames are duplicates, and one of them can go. In
// motion there is none, and the start has to end.
bool VioStart::ShouldEnd(const Matrix<15, 15>& covariance,
                         const ImuIntervals& imu,
                         SlidingWindow& window,
                         std::vector<KeyframePose>& finished) const {
  if (SpanOf(window) < options_.window.start_s) return false;
  if (TiltSigma(covariance, window) < options_.window.start_tilt_deg * kDegree) return true;
  const int num_frames = static_cast<int>(window.frames.size());
  if (num_frames <= kMinStartFrames) return false;
  const int victim = MostRedundantFrame(window, 1, num_frames - 3, options_.window.covisible_share);
  if (!IsDuplicate(window, victim)) return num_frames > options_.window.max_start_keyframes;
  RemoveDuplicate(victim, imu, window, finished);
  return false;
}

}  // namespace facet
