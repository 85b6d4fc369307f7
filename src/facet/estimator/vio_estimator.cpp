// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/vio_estimator.h"

#include <algorithm>
#include <utility>

#include "facet/estimator/factors/imu_factor.h"
#include "facet/estimator/planes/plane_membership.h"
#include "facet/estimator/solver/marginalization.h"
#include "facet/estimator/window/landmark_depth.h"
#include "facet/estimator/window/window_policy.h"
#include "facet/estimator/window/window_snapshot.h"

namespace facet {

namespace {

constexpr int kRepairIterations = 4;
// Landmarks that tie a keyframe to what was seen before.
constexpr int kMinLandmarksSeen = 8;

// Landmarks that constrain the window and are seen in its newest frame.
int NumSeenInNewest(const SlidingWindow& window) {
  return static_cast<int>(std::count_if(
      window.landmarks().begin(), window.landmarks().end(), [&](const WindowLandmark& l) {
        return IsConstraining(l) && l.observations.back().frame == window.newest_frame();
      }));
}

bool HasImu(const WindowFrame& frame) {
  return !frame.imu_link || !frame.imu_link->is_synthetic;
}

std::optional<double> NewestImuError(const SlidingWindow& window) {
  const std::optional<ImuLink>& link = window.frames.back().imu_link;
  if (!link || link->is_synthetic) return std::nullopt;
  const auto newest = window.frames.rbegin();
  return ImuErrorSigma(*link, std::next(newest)->x, newest->x, window.GyroScale());
}

void Report(const SlidingWindow& window, int i, std::vector<KeyframePose>& finished) {
  const WindowFrame& frame = window.frames[i];
  if (frame.is_reported) finished.push_back({frame.id, frame.x.t, window.BodyAt(i)});
}

}  // namespace

VioEstimator::VioEstimator(const StereoRig& rig,
                           const ImuNoise& noise,
                           const EstimatorOptions& options)
    : rig_(rig),
      options_(options),
      window_(rig.T_BC[0]),
      segments_(BiasWalk(noise, options.imu)),
      imu_(noise, options.imu, rig.time_offset),
      start_(rig, options),
      calibration_(rig, options.calibration),
      bias_watch_(noise),
      stated_covariance_(options.imu.accel_noise_scale, options.calibration.AxesSigma()),
      optimizer_(rig, options),
      planes_(options),
      updater_(rig, options.solver, BiasWalk(noise, options.imu)) {
  calibration_.Begin(window_);
  if (options.calibration.IsHeld()) held_fields_ = FieldsOf(rig);
}

EstimatorResult VioEstimator::AddFrame(const FrameObservations& observations,
                                       const ImuInterval& imu,
                                       StageTimes& times) {
  if (!IsAfterNewest(observations.t)) {
    EstimatorResult refused;
    refused.status = is_initialised() ? TrackingStatus::kDegraded : TrackingStatus::kInitialising;
    refused.reason = "stamp is not after the previous frame's";
    return refused;
  }
  {
    ScopedStage stage(times, Stage::kImu);
    AppendFrame(observations, imu);
  }
  EstimatorResult result = Estimate(observations, times);
  if (result.has_state) {
    result.causal = AtImu(result);
    calibration_.MoveToImage(
        window_, intermediate_ ? ToImage(*intermediate_) : window_.frames.back().to_image, result);
    result.segment = segments_.id();
    result.solved_covariance = InWorld(result.covariance, result.state);
    result.covariance = Stated(result.covariance, result.state);
    if (contradiction_.IsRecentAt(result.state.t) && result.status == TrackingStatus::kOk) {
      result.status = TrackingStatus::kDegraded;
      result.reason = "IMU and images contradict each other";
    }
    result.bias_drift = bias_drift_;
    if (bias_drift_ && result.status == TrackingStatus::kOk) {
      result.status = TrackingStatus::kDegraded;
      result.reason = "a bias of the IMU changes too fast";
    }
  }
  return result;
}

Matrix<15, 15> VioEstimator::InWorld(const Matrix<15, 15>& covariance, const NavState& x) const {
  return segments_.InWorld(covariance, x) + contradiction_.CovarianceOf(x);
}

Matrix<15, 15> VioEstimator::Stated(const Matrix<15, 15>& covariance, const NavState& x) const {
  Matrix<15, 15> stated = InWorld(stated_covariance_.Of(covariance), x);
  const double of_origin = stated_covariance_.OfOrigin();
  if (of_origin > 1) stated += (of_origin - 1) * segments_.InWorld(Matrix<15, 15>::Zero(), x);
  return stated;
}

CausalState VioEstimator::AtImu(const EstimatorResult& result) const {
  CausalState causal{result.state, Stated(result.covariance, result.state), window_.GyroScale()};
  causal.x.t = result.state.t + rig_.time_offset;
  return causal;
}

EstimatorResult VioEstimator::Estimate(const FrameObservations& observations, StageTimes& times) {
  if (!is_initialised()) return Start(observations, times);
  return intermediate_ ? TrackIntermediateFrame(observations, times)
                       : TrackKeyframe(observations, times);
}

bool VioEstimator::IsAfterNewest(Timestamp t) const {
  if (window_.frames.empty()) return !segments_.is_between() || t > segments_.reckoned().t;
  return t > (intermediate_ ? intermediate_->x : window_.frames.back().x).t;
}

// The new frame is where the IMU predicts it. Until the next keyframe it stays beside the window if
// it is none.
void VioEstimator::AppendFrame(const FrameObservations& observations, const ImuInterval& imu) {
  WindowFrame frame;
  frame.id = observations.frame;
  frame.is_keyframe = observations.is_keyframe || !is_initialised();
  frame.is_reported = observations.is_keyframe;
  frame.x.t = observations.t;
  if (window_.frames.empty()) {
    if (segments_.is_between()) {
      segments_.Follow(imu_.Next(segments_.reckoned(), std::nullopt, observations.t, imu).link);
    } else {
      imu_.Begin(observations.t);
    }
    if (!imu.samples.empty()) frame.to_image.w_B = imu.samples.back().gyro;
    VioStart::AppendFirstFrame(std::move(frame), imu, options_.start, window_);
    return;
  }
  const NavState last = intermediate_ ? intermediate_->x : window_.frames.back().x;
  imu_.SetGyroScale(window_.GyroScale());
  std::optional<ImuLink> passing;
  if (intermediate_) passing = std::move(intermediate_->link);
  intermediate_.reset();
  PredictedFrame predicted = imu_.Next(last, std::move(passing), observations.t, imu);
  if (segments_.is_between()) segments_.Follow(predicted.link);
  if (!frame.is_keyframe) {
    intermediate_ = std::move(predicted);
    return;
  }
  frame.x = frame.lin = predicted.x;
  frame.to_image = ToImage(predicted);
  frame.imu_link = std::move(predicted.link);
  window_.frames.push_back(std::move(frame));
}

ImageMotion VioEstimator::ToImage(const PredictedFrame& frame) const {
  return MotionToImage(frame.link, frame.x, SelfCalibration::TimeOffset(window_));
}

std::vector<PreparedObservation> VioEstimator::Prepare(
    const FrameObservations& observations) const {
  return PrepareObservations(observations, rig_, options_.solver.pixel_sigma_scale, held_fields_);
}

std::vector<PreparedObservation> VioEstimator::Believable(
    std::vector<PreparedObservation> observations, const ImuLink& link) {
  if (link.is_synthetic) return observations;
  const InnovationTest test = updater_.TestInnovations(observations, link);
  const Timestamp t = (intermediate_ ? intermediate_->x : window_.frames.back().x).t;
  if (!innovation_judge_.LeavesOut(test, t)) return observations;
  if (!intermediate_) Remember(test, observations, window_);
  LeaveOutMoving(test, window_, observations);
  return observations;
}

EstimatorResult VioEstimator::Start(const FrameObservations& observations, StageTimes& times) {
  ScopedStage stage(times, Stage::kOptimize);
  AppendObservations(Prepare(observations), window_);
  StartAttempt attempt = start_.Try(segments_.PredictedPose(), imu_, optimizer_, window_);
  EstimatorResult result;
  result.num_constraining = attempt.num_constraining;
  result.reason = std::move(attempt.reason);
  result.solve = attempt.solve;
  if (attempt.has_failed) Forget();
  if (!attempt.has_started) return result;
  newest_covariance_ = attempt.covariance;
  calibration_.TakeClock(window_, optimizer_.solver());
  const WindowFrame& newest = window_.frames.back();
  segments_.Begin(newest.x);
  segments_.Keep(newest.x, newest_covariance_, true);
  SetState(newest.x, newest_covariance_, NumSeenInNewest(window_), HasImu(newest), result);
  updater_.SetReference(window_, newest_covariance_, optimizer_.noise());
  return result;
}

EstimatorResult VioEstimator::TrackKeyframe(const FrameObservations& observations,
                                            StageTimes& times) {
  EstimatorResult result;
  {
    ScopedStage stage(times, Stage::kOptimize);
    const WindowFrame& frame = window_.frames.back();
    AppendObservations(Believable(Prepare(observations), *frame.imu_link), window_);
    InitializeDepths(optimizer_.UpdateGeometry(window_), window_);
    imu_.Relinearize(window_);
    planes_.TakeEffect(optimizer_.noise(), optimizer_.geometry(), window_);
    result.solve = Solve();
    WindowSolver& solver = optimizer_.solver();
    newest_covariance_ = solver.NewestFrameCovariance();
    calibration_.TakeClock(window_, solver);
    result.imu_error_sigma = NewestImuError(window_);
    if (result.imu_error_sigma) {
      const auto end = window_.frames.rbegin();
      contradiction_.Add(*end->imu_link, std::next(end)->x, end->x, *result.imu_error_sigma);
    }
    WatchBiases();
    JudgeNoise();
    planes_.Judge(
        solver.PlaneInformation(), solver.PlaneCovariances(), optimizer_.noise(), window_);
    RemoveOutliers();
  }
  const WindowFrame& newest = window_.frames.back();
  SetState(newest.x, newest_covariance_, NumSeenInNewest(window_), HasImu(newest), result);
  if (segments_.HasDriftedAway(newest.x, newest_covariance_)) SetLost("position unknown", result);
  if (result.status == TrackingStatus::kLost) {
    StartOver(result);
    return result;
  }
  segments_.Keep(newest.x, newest_covariance_, result.num_constraining >= kMinLandmarksSeen);
  calibration_.Doubt(newest.x.t, contradiction_.IsRecentAt(newest.x.t));
  calibration_.Keep(window_, optimizer_.solver());
  stated_covariance_.SetCalibrationSurprise(calibration_.Surprise());
  stated_covariance_.AddKeyframe(newest_covariance_);
  ScopedStage stage(times, Stage::kMarginalize);
  updater_.SetReference(window_, newest_covariance_, optimizer_.noise());
  Shrink(result.finished_keyframes);
  return result;
}

EstimatorResult VioEstimator::TrackIntermediateFrame(const FrameObservations& observations,
                                                     StageTimes& times) {
  ScopedStage stage(times, Stage::kOptimize);
  EstimatorResult result;
  const FrameUpdateResult update =
      updater_.Update(Believable(Prepare(observations), intermediate_->link),
                      intermediate_->link,
                      optimizer_.noise(),
                      intermediate_->x);
  if (update.ok) newest_covariance_ = update.covariance;
  SetState(intermediate_->x,
           newest_covariance_,
           update.num_used,
           !intermediate_->link.is_synthetic,
           result);
  if (update.num_used < kMinLandmarksSeen &&
      segments_.HasDriftedAway(intermediate_->x, newest_covariance_)) {
    SetLost("position unknown", result);
  }
  if (result.status == TrackingStatus::kLost) StartOver(result);
  return result;
}

SolveSummary VioEstimator::Solve() {
  if (!window_.planes.empty()) before_solve_.Save(window_);
  const SolveSummary summary = optimizer_.Solve(window_, options_.solver.keyframe_iterations);
  if (window_.planes.empty() ||
      !planes_.DetachWrongLandmarks(
          optimizer_.noise(), optimizer_.UpdateGeometry(window_), window_)) {
    return summary;
  }
  before_solve_.Restore(window_);
  WeighPlanes(optimizer_.noise(), window_);
  return optimizer_.Solve(window_, kRepairIterations);
}

void VioEstimator::RemoveOutliers() {
  const OutlierRemoval removal = optimizer_.RemoveOutliers(window_);
  planes_.FollowOutlierRemoval(optimizer_.noise(), optimizer_.geometry(), window_);
  optimizer_.LearnFrom(removal);
}

void VioEstimator::Shrink(std::vector<KeyframePose>& finished) {
  planes_.RemoveRetired(window_);
  if (!start_.EndIfDue(newest_covariance_, imu_, optimizer_, window_, finished)) return;
  while (true) {
    MarginalizationPlan plan = PlanMarginalization(window_, options_.window);
    planes_.RetireIn(window_, plan);
    if (plan.IsEmpty()) break;
    planes_.CutNonPersistent(plan, window_);
    for (std::size_t i = 0; i < window_.frames.size(); ++i) {
      if (plan.drop_frame[i]) Report(window_, static_cast<int>(i), finished);
    }
    Marginalize(plan, rig_, optimizer_.noise(), window_);
  }
  calibration_.Walk(window_);
}

// What contradicts the images bends the biases for a while, and is told for itself.
void VioEstimator::WatchBiases() {
  const NavState& x = window_.frames.back().x;
  bias_drift_.reset();
  if (contradiction_.IsRecentAt(x.t)) return;
  const Vector<15> sigma = newest_covariance_.diagonal().cwiseMax(0).cwiseSqrt();
  bias_drift_ = bias_watch_.Add({x.t, x.bias, sigma.segment<3>(9), sigma.segment<3>(12)});
  if (bias_drift_) contradiction_.AddTilt(x, TiltOf(*bias_drift_, options_.imu.gravity_mps2));
}

// Without landmarks the solve repeats what the IMU says.
void VioEstimator::JudgeNoise() {
  const auto end = window_.frames.rbegin();
  if (!end->imu_link || end->imu_link->is_synthetic ||
      NumSeenInNewest(window_) < kMinLandmarksSeen || contradiction_.IsRecentAt(end->x.t)) {
    return;
  }
  stated_covariance_.AddImuError(
      ImuPositionError(*end->imu_link, std::next(end)->x, end->x, window_.GyroScale()));
}

void VioEstimator::StartOver(EstimatorResult& result) {
  const WindowFrame& newest = window_.frames.back();
  const ImuLink* to_lost = newest.imu_link ? &*newest.imu_link : nullptr;
  int num_good = window_.newest_frame();
  if (intermediate_) {
    to_lost = &intermediate_->link;
    ++num_good;
  }
  segments_.End(to_lost);
  contradiction_.StartOver(result.state.t);
  stated_covariance_.StartOver();
  bias_watch_.Break();
  bias_drift_.reset();
  for (int i = 0; i < num_good; ++i)
    Report(window_, i, result.finished_keyframes);
  Forget();
  result.was_reset = true;
}

void VioEstimator::Forget() {
  window_ = SlidingWindow(rig_.T_BC[0]);
  calibration_.Begin(window_);
  intermediate_.reset();
  newest_covariance_.setZero();
  start_ = VioStart(rig_, options_);
  optimizer_ = WindowOptimizer(rig_, options_);
  planes_ = PlaneLifecycle(options_);
  innovation_judge_ = {};
}

MapSnapshot VioEstimator::Snapshot() const {
  if (window_.frames.empty()) return {};
  MapSnapshot snapshot = SnapshotWindow(window_, rig_, planes_.covariances());
  if (intermediate_) snapshot.latest = intermediate_->x;
  return snapshot;
}

}  // namespace facet
