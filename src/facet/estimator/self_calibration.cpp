// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/self_calibration.h"

#include "facet/estimator/solver/calibration_walk.h"
#include "facet/estimator/start/start_calibration.h"
#include "facet/geometry/angles.h"

namespace facet {

namespace {

constexpr Duration kKeepEvery{1'000'000'000};
constexpr Duration kStepEvery{10'000'000'000};
// Share of the first uncertainty, 1-sigma, that a random step has. More than a tenth makes long
// runs worse; with this it has added up to half of the first uncertainty after an hour.
constexpr double kStepShare = 0.03;
// After the large step.
constexpr Duration kSettles{5'000'000'000};

CalibrationMatrix BaselineCovariance(const StereoRig& rig, double share) {
  CalibrationVector change = CalibrationVector::Zero();
  change.segment<3>(kStereoTranslation) = share * rig.T_C1C0().p;
  return change * change.transpose();
}

// What uncalibrated rigs have: a data sheet's focal lengths, cameras that were glued by eye, a
// driver's stamps. Added to what a careful calibration leaves.
CalibrationMatrix RoughCovariance(const StereoRig& rig, const CalibrationOptions& options) {
  constexpr double kFocal = 0.01, kCentre_px = 5, kTurn = 0.3 * kDegree, kBaseline = 0.02;
  constexpr double kMountTurn = 0.5 * kDegree, kMount_m = 0.01, kTime_s = 0.01;
  CalibrationMatrix covariance = CalibrationMatrix::Zero();
  const auto add = [&](const CalibrationVector& sigmas) {
    covariance += sigmas * sigmas.transpose();
  };
  const auto add_each = [&](int first, int count, double sigma) {
    covariance.diagonal().segment(first, count).array() += sigma * sigma;
  };
  if (options.lens) {
    CalibrationVector both = CalibrationVector::Zero();
    for (int c = 0; c < 2; ++c) {
      const CameraIntrinsics& k = rig.cameras[static_cast<std::size_t>(c)].intrinsics();
      CalibrationVector one = CalibrationVector::Zero();
      one.segment<2>(c * kNumIntrinsics) = kFocal * Vector2d(k.fx, k.fy);
      both += one;
      add(one);
      add_each(c * kNumIntrinsics + 2, 2, kCentre_px);
    }
    add(both);
    add_each(kStereoRotation, 3, kTurn);
    covariance += BaselineCovariance(rig, kBaseline);
  }
  if (options.mount) {
    add_each(kMountRotation, 3, kMountTurn);
    add_each(kMountTranslation, 3, kMount_m);
  }
  if (options.time) add_each(kTimeOffset, 1, kTime_s);
  return covariance;
}

}  // namespace

SelfCalibration::SelfCalibration(const StereoRig& rig, const CalibrationOptions& options)
    : rig_(rig), options_(options) {
  if (!options.IsHeld()) start_covariance_ = StartCovariance(rig, options);
}

void SelfCalibration::Begin(SlidingWindow& window) const {
  if (!start_covariance_) return;
  window.calibration.emplace(rig_, *start_covariance_);
  if (!kept_) return;
  window.calibration->SetDelta(kept_->delta);
  window.calibration->Restart(kept_->covariance);
}

void SelfCalibration::TakeClock(const SlidingWindow& window, const WindowSolver& solver) {
  if (window.calibration) clock_ = solver.NewestFrameWithClock();
}

void SelfCalibration::Keep(const SlidingWindow& window, const WindowSolver& solver) {
  if (!window.calibration) return;
  const Timestamp now = window.frames.back().x.t;
  if (kept_ && now - kept_->t < kKeepEvery) return;
  kept_ = Kept{now,
               window.calibration->delta(),
               solver.CalibrationCovariance(),
               window.calibration->Refined()};
  if (freed_at_ && now - *freed_at_ < kSettles) return;
  gross_deviations_ = GrossDeviations(rig_, kept_->delta, kept_->covariance, *start_covariance_);
}

void SelfCalibration::Walk(SlidingWindow& window) {
  if (!window.calibration) return;
  const Timestamp now = window.frames.back().x.t;
  if (!freed_at_ && !gross_deviations_.empty()) {
    TakeRandomStep(RoughCovariance(rig_, options_), window.prior);
    freed_at_ = now;
    gross_deviations_.clear();
  }
  if (doubted_share_ != 0 && options_.lens) {
    TakeRandomStep(BaselineCovariance(rig_, doubted_share_), window.prior);
    doubted_share_ = 0;
  }
  if (!last_step_) last_step_ = now;
  if (now - *last_step_ < kStepEvery) return;
  last_step_ = now;
  TakeRandomStep(kStepShare * kStepShare * *start_covariance_, window.prior);
}

void SelfCalibration::MoveToImage(const SlidingWindow& window,
                                  const Vector3d& w_B,
                                  EstimatorResult& result) const {
  if (!window.calibration) return;
  NavState& x = result.state;
  const BodyRates rates{w_B, x.T_WB.q.conjugate() * x.v_WB};
  x.T_WB = window.calibration->AtImage(x.T_WB, rates);
  Vector<15> moved = Vector<15>::Zero();
  moved.head<3>() = rates.w_B;
  moved.segment<3>(3) = x.v_WB;
  const Matrix<15, 15> cross = moved * clock_.with_newest.transpose();
  result.covariance += cross + cross.transpose() + clock_.variance * moved * moved.transpose();
}

std::optional<StereoRig> SelfCalibration::Refined() const {
  if (!kept_) return std::nullopt;
  StereoRig rig = kept_->rig;
  rig.covariance = std::make_shared<const MatrixXd>(kept_->covariance);
  return rig;
}

}  // namespace facet
