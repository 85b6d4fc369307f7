// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/vio_estimator.h"

#include <algorithm>
#include <cmath>

#include "facet/estimator/factors/imu_factor.h"
#include "facet/estimator/planes/plane_anchor.h"
#include "facet/estimator/planes/plane_budget.h"
#include "facet/estimator/planes/plane_judgement.h"
#include "facet/estimator/planes/plane_membership.h"
#include "facet/estimator/solver/outlier_removal.h"
#include "facet/estimator/window/landmark_depth.h"
#include "facet/estimator/window/window_policy.h"
#include "facet/estimator/window/window_snapshot.h"
#include "facet/geometry/angles.h"

namespace facet {

namespace {

// IMU noise over an interval with a hole, and over one without any sample, times the usual.
constexpr double kGapNoiseScale = 10.0;
constexpr double kNoImuNoiseScale = 300.0;
// Bias change that makes an interval worth integrating again.
constexpr double kRelinearizeGyro = 2e-3;   // rad/s
constexpr double kRelinearizeAccel = 2e-2;  // m/s^2
constexpr int kRepairIterations = 4;
constexpr int kFewWrongMembers = 5;
constexpr int kMinLandmarksOk = 8;
// Beyond these the state is of no use to anybody: start again.
constexpr double kLostVelocitySigma = 5.0;  // m/s
constexpr double kLostSpeed = 100.0;        // m/s

PreintegrationNoise Scaled(const PreintegrationNoise& noise, double scale) {
  return {noise.gyro * scale, noise.accel * scale, noise.integration * scale};
}

// Whether the samples can be integrated: finite, in order of time, from t0 to t1 or nearly so.
bool IsUsable(const std::vector<ImuSample>& samples, Timestamp t0, Timestamp t1) {
  constexpr Duration kMaxEndError{10'000'000};
  if (samples.size() < 2 || samples.front().t != t0) return false;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].gyro.allFinite() || !samples[i].accel.allFinite()) return false;
    if (i > 0 && samples[i].t < samples[i - 1].t) return false;
  }
  return std::max(samples.back().t - t1, t1 - samples.back().t) <= kMaxEndError;
}

// What an IMU would have seen at constant velocity; for intervals without usable samples.
std::vector<ImuSample> ConstantVelocity(const NavState& x, Timestamp t0, Timestamp t1) {
  ImuSample sample{t0, x.bias.b_g, x.bias.b_a - x.T_WB.q.conjugate() * GravityInWorld()};
  std::vector<ImuSample> samples = {sample, sample};
  samples.back().t = std::max(t0, t1);
  return samples;
}

}  // namespace

VioEstimator::VioEstimator(const StereoRig& rig,
                           const ImuNoise& noise,
                           const EstimatorOptions& options)
    : rig_(rig),
      options_(options),
      imu_noise_(InflatedNoise(noise, options.imu)),
      bias_walk_(noise, options.imu),
      noise_(options),
      window_(rig.T_BC[0]),
      solver_(rig, options.solver),
      updater_(rig, options.solver),
      geometry_(rig) {}

EstimatorResult VioEstimator::AddFrame(const FrameObservations& observations,
                                       const ImuInterval& imu,
                                       StageTimes& times) {
  if (!window_.frames.empty() &&
      observations.t <= (passing_ ? *passing_ : window_.frames.back()).x.t) {
    EstimatorResult result;
    result.status = initialised_ ? TrackingStatus::kDegraded : TrackingStatus::kInitialising;
    result.reason = "stamp is not after the previous frame's";
    return result;
  }
  {
    ScopedStage stage(times, Stage::kImu);
    AppendFrame(observations, imu);
  }
  if (!initialised_) return Start(observations, times);
  return passing_ ? TrackPassingFrame(observations, times) : TrackKeyframe(observations, times);
}

void VioEstimator::Assign(const PlaneAssignments& assignments) {
  const auto append = [](const auto& from, auto& to) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(assignments.created, assignments_.created);
  append(assignments.joined, assignments_.joined);
  append(assignments.left, assignments_.left);
  append(assignments.ended, ended_planes_);
  append(assignments.related, assignments_.related);
  append(assignments.sighted, assignments_.sighted);
  append(assignments.projected, assignments_.projected);
  append(assignments.unprojected, assignments_.unprojected);
}

EstimatorResult VioEstimator::TrackKeyframe(const FrameObservations& observations,
                                            StageTimes& times) {
  EstimatorResult result;
  {
    ScopedStage stage(times, Stage::kOptimize);
    AppendObservations(Prepare(observations), window_);
    geometry_.Update(window_.frames);
    InitializeDepths(geometry_, window_);
    RelinearizeImu();
    TakeAssignments();
    if (!window_.planes.empty()) before_solve_.Save(window_);
    result.solve = solver_.Solve(window_, noise_, options_.solver.keyframe_iterations);
    if (DropWrongMembers()) {
      before_solve_.Restore(window_);
      WeighPlanes(noise_, window_);
      result.solve = solver_.Solve(window_, noise_, kRepairIterations);
    }
    newest_covariance_ = solver_.NewestFrameCovariance();
    result.imu_error_sigma = NewestImuError();
    JudgePlanes();
    KeepPlaneCovariances();
    RemoveOutliers();
  }
  FillResult(window_.frames.back(), NumSeenInNewest(), result);
  if (result.status == TrackingStatus::kLost) {
    FinishAllKeyframes(result.finished_keyframes);
    Reset();
    result.was_reset = true;
    return result;
  }
  last_good_ = result.state;
  ScopedStage stage(times, Stage::kMarginalize);
  updater_.SetReference(window_, newest_covariance_, noise_);
  Shrink(result.finished_keyframes);
  return result;
}

void VioEstimator::KeepPlaneCovariances() {
  const std::vector<Matrix<9, 9>> covariances = solver_.PlaneCovariances();
  plane_covariances_.clear();
  for (std::size_t k = 0; k < window_.planes.size(); ++k) {
    Matrix<10, 9> J = Matrix<10, 9>::Zero();
    J.topLeftCorner<6, 6>().setIdentity();
    J.block<3, 2>(6, 6) = TangentBasis(window_.planes[k].n_lin);
    J(9, 8) = 1;
    plane_covariances_.emplace_back(window_.planes[k].id, J * covariances[k] * J.transpose());
  }
}

void VioEstimator::TakeAssignments() {
  if (window_.planes.empty() && assignments_.IsEmpty()) return;
  ApplyAssignments(assignments_, options_.planes, noise_, geometry_, window_);
  ApplyProjections(assignments_, options_.projection.convert_back, window_);
  assignments_ = {};
  RemoveUnsupportedPlanes(options_.planes.min_landmarks, window_);
  FollowSupport(options_.planes.anchor_distance_m, window_);
  WeighPlanes(noise_, window_);
}

void VioEstimator::JudgePlanes() {
  if (window_.planes.empty()) return;
  const PlaneOptions& planes = options_.planes;
  const std::vector<Matrix3d> information = solver_.PlaneInformation();
  MarkSettledPlanes(information, planes, window_);
  DropViolatedRelations(noise_.relations, planes.relations.outlier_sigma, window_);
  for (const PlaneId id : ExcessPlanes(window_, information, planes.max_planes))
    ended_planes_.push_back(id);
}

EstimatorResult VioEstimator::TrackPassingFrame(const FrameObservations& observations,
                                                StageTimes& times) {
  ScopedStage stage(times, Stage::kOptimize);
  EstimatorResult result;
  const FrameUpdateResult update =
      updater_.Update(Prepare(observations), passing_->imu_link.value(), noise_, passing_->x);
  if (update.ok) newest_covariance_ = update.covariance;
  FillResult(*passing_, update.num_used, result);
  return result;
}

void VioEstimator::UpdateSqrtInfo(ImuLink& link) const {
  link.sqrt_info = ImuSqrtInfo(link.measured, bias_walk_);
}

void VioEstimator::AppendFirstFrame(WindowFrame frame, const ImuInterval& imu) {
  Vector3d mean = Vector3d::Zero();
  for (const ImuSample& sample : imu.samples)
    mean += sample.accel;
  if (mean.norm() > 1.0) frame.x.T_WB.q = RotationBetween(mean, Vector3d::UnitZ());
  frame.lin = frame.x;
  first_t_ = frame.x.t;
  window_.start_prior.emplace(frame.id, frame.x.T_WB, options_.start);
  window_.frames.push_back(std::move(frame));
}

void VioEstimator::AppendFrame(const FrameObservations& observations, const ImuInterval& imu) {
  WindowFrame frame;
  frame.id = observations.frame;
  frame.is_keyframe = observations.is_keyframe || !initialised_;
  frame.is_reported = observations.is_keyframe;
  frame.x.t = observations.t;
  if (window_.frames.empty()) {
    AppendFirstFrame(std::move(frame), imu);
    return;
  }

  const WindowFrame& last = passing_ ? *passing_ : window_.frames.back();
  // Intervals follow each other without a hole, in the clock of the IMU.
  const Timestamp t0 =
      last.imu_link ? last.imu_link->measured.samples().back().t : last.x.t + rig_.time_offset;
  const Timestamp t1 = observations.t + rig_.time_offset;
  const bool no_imu = !IsUsable(imu.samples, t0, t1);
  const std::vector<ImuSample> samples = no_imu ? ConstantVelocity(last.x, t0, t1) : imu.samples;
  const double scale = no_imu ? kNoImuNoiseScale : imu.has_hole ? kGapNoiseScale : 1.0;
  ImuPreintegration step(last.x.bias, Scaled(imu_noise_, scale));
  step.Integrate(samples);
  frame.x = step.Predict(last.x);
  frame.x.t = observations.t;
  frame.lin = frame.x;
  ImuLink& link = frame.imu_link.emplace();
  link.is_invented = no_imu;
  if (!passing_) {
    link.measured = std::move(step);
  } else if (scale == 1.0) {
    // The previous frame was only passing through: its IMU interval goes on to this frame.
    link.measured = std::move(passing_->imu_link->measured);
    link.measured.Integrate(samples);
  } else {
    std::vector<ImuSample> all = passing_->imu_link->measured.samples();
    all.insert(all.end(), samples.begin() + 1, samples.end());
    link.measured = ImuPreintegration(last.x.bias, Scaled(imu_noise_, scale));
    link.measured.Integrate(all);
  }
  UpdateSqrtInfo(link);
  passing_.reset();
  if (frame.is_keyframe) {
    window_.frames.push_back(std::move(frame));
  } else {
    passing_ = std::move(frame);
  }
}

std::vector<PreparedObservation> VioEstimator::Prepare(
    const FrameObservations& observations) const {
  return PrepareObservations(observations, rig_, options_.solver.pixel_sigma_scale);
}

void VioEstimator::RelinearizeImu() {
  for (std::size_t j = 1; j < window_.frames.size(); ++j) {
    std::optional<ImuLink>& link = window_.frames[j].imu_link;
    if (!link) continue;
    const ImuBias& bias = window_.frames[j - 1].x.bias;
    if ((bias.b_g - link->measured.bias().b_g).norm() < kRelinearizeGyro &&
        (bias.b_a - link->measured.bias().b_a).norm() < kRelinearizeAccel) {
      continue;
    }
    link->measured.Reintegrate(bias);
    UpdateSqrtInfo(*link);
  }
}

// Landmarks on planes where they do not belong bend the window: when many are found after the
// solve, it is solved anew without them, before their pull is frozen or good observations look
// wrong. From where it was: a few iterations do not lead back from far off.
bool VioEstimator::DropWrongMembers() {
  const int before = NumPlaneConstraints();
  if (before == 0) return false;
  geometry_.Update(window_.frames);
  const int dropped = DetachOutliers(geometry_, noise_, options_.planes.outlier_sigma, window_);
  return dropped > std::max(kFewWrongMembers, before / 10);
}

void VioEstimator::RemoveOutliers() {
  geometry_.Update(window_.frames);
  const OutlierRemoval removal =
      outlier_remover_.Remove(geometry_, noise_, options_.solver.outlier_sigma, window_);
  if (!window_.planes.empty()) {
    // Without those observations vision places some landmarks elsewhere.
    DetachOutliers(geometry_, noise_, options_.planes.outlier_sigma, window_);
    RemoveUnsupportedPlanes(options_.planes.min_landmarks, window_);
  }
  if (!removal.median_sigma) return;
  usual_error_.Add(*removal.median_sigma);
  noise_ = FactorNoise(options_, usual_error_);
}

void VioEstimator::FinishAllKeyframes(std::vector<KeyframePose>& finished) const {
  // The newest one is what was lost.
  for (std::size_t i = 0; i + 1 < window_.frames.size(); ++i) {
    const WindowFrame& frame = window_.frames[i];
    if (frame.is_reported) finished.push_back({frame.id, frame.x.t, frame.x.T_WB});
  }
}

void VioEstimator::Shrink(std::vector<KeyframePose>& finished) {
  RemoveEndedPlanes();
  if (!EndStart(finished)) return;
  while (true) {
    MarginalizationPlan plan = PlanMarginalization(window_, options_.window);
    EndPlanes(plan);
    if (plan.IsEmpty()) return;
    CutUnsettledLinks(plan.drop_landmark, window_);
    CutSightings(plan.drop_frame, window_);
    CutUnsettledRelations(plan.drop_plane, window_);
    for (std::size_t i = 0; i < window_.frames.size(); ++i) {
      const WindowFrame& frame = window_.frames[i];
      if (plan.drop_frame[i] && frame.is_reported)
        finished.push_back({frame.id, frame.x.t, frame.x.T_WB});
    }
    Marginalize(plan, rig_, noise_, window_);
  }
}

void VioEstimator::RemoveEndedPlanes() {
  std::erase_if(ended_planes_, [&](PlaneId id) {
    const int plane = window_.IndexOf(id);
    if (plane < 0) return true;
    if (window_.planes[plane].frozen) return false;
    window_.RemovePlane(plane);
    return true;
  });
}

void VioEstimator::EndPlanes(MarginalizationPlan& plan) {
  for (const PlaneId id : ended_planes_) {
    const int plane = window_.IndexOf(id);
    if (plane >= 0) plan.drop_plane[plane] = 1;
  }
  ended_planes_.clear();
}

int VioEstimator::NumSeenInNewest() const {
  const int newest = static_cast<int>(window_.frames.size()) - 1;
  return static_cast<int>(std::count_if(
      window_.landmarks().begin(), window_.landmarks().end(), [&](const WindowLandmark& l) {
        return IsConstraining(l) && l.observations.back().frame == newest;
      }));
}

std::optional<double> VioEstimator::NewestImuError() const {
  const WindowFrame& newest = window_.frames.back();
  if (!newest.imu_link || newest.imu_link->is_invented) return std::nullopt;
  const WindowFrame& before = window_.frames[window_.frames.size() - 2];
  return ImuErrorSigma(*newest.imu_link, before.x, newest.x);
}

void VioEstimator::FillResult(const WindowFrame& frame,
                              int num_used,
                              EstimatorResult& result) const {
  result.has_state = true;
  result.state = frame.x;
  result.covariance = newest_covariance_;
  result.num_constraining = num_used;
  result.status = TrackingStatus::kOk;
  result.reason.clear();
  if (num_used < kMinLandmarksOk) {
    result.status = TrackingStatus::kDegraded;
    result.reason = "few landmarks";
  } else if (frame.imu_link && frame.imu_link->is_invented) {
    result.status = TrackingStatus::kDegraded;
    result.reason = "no IMU";
  }
  const double velocity_sigma = std::sqrt(newest_covariance_.block<3, 3>(6, 6).trace());
  const bool sane = frame.x.T_WB.p.allFinite() && frame.x.T_WB.q.coeffs().allFinite() &&
                    frame.x.v_WB.allFinite() && frame.x.bias.b_g.allFinite() &&
                    frame.x.bias.b_a.allFinite() && newest_covariance_.allFinite();
  if (!sane || !(velocity_sigma < kLostVelocitySigma) || frame.x.v_WB.norm() > kLostSpeed) {
    result.status = TrackingStatus::kLost;
    result.reason = sane ? "velocity unknown" : "numerical failure";
    result.has_state = sane;
  }
}

void VioEstimator::Reset() {
  window_ = SlidingWindow(rig_.T_BC[0]);
  assignments_ = {};
  ended_planes_.clear();
  plane_covariances_.clear();
  passing_.reset();
  initialised_ = start_is_over_ = false;
  newest_covariance_.setZero();
  usual_error_ = {};
  noise_ = FactorNoise(options_);
}

int VioEstimator::NumPlaneConstraints() const {
  return window_.NumMembers();
}

MapSnapshot VioEstimator::Snapshot() const {
  if (window_.frames.empty()) return {};
  MapSnapshot snapshot = SnapshotWindow(window_, rig_, plane_covariances_);
  if (passing_) snapshot.latest = passing_->x;
  return snapshot;
}

}  // namespace facet
