// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/self_calibration.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "facet/calibration/error_evidence.h"
#include "facet/calibration/relative_covariance.h"
#include "facet/calibration/rough_focal_lengths.h"
#include "facet/calibration/rough_lenses.h"
#include "facet/calibration/rough_mount.h"
#include "facet/estimator/solver/calibration_walk.h"
#include "facet/estimator/start/start_calibration.h"
#include "facet/estimator/window/calibration_information.h"

namespace facet {

namespace {

constexpr Duration kKeepEvery{1'000'000'000};
constexpr Duration kStepEvery{10'000'000'000};
// Share of the first uncertainty, 1-sigma, that a random step has. More than a tenth makes long
// runs worse; with this it has added up to half of the first uncertainty after an hour.
constexpr double kStepShare = 0.03;
// A fault of a sensor passes, an error of the calibration does not.
constexpr Duration kMaxDoubt{5'000'000'000};
// After a large step.
constexpr Duration kSettles{5'000'000'000};
// Of each part. Landmarks and velocities of the time before a step still fit the wrong calibration,
// and what is learnt with them is too certain; they are gone before the last one.
constexpr int kMaxLargeSteps = 3;
// Of a variance that is left; less is rounding.
constexpr double kLeastShare = 1e-12;
// Since the first look; and until lenses that were given room are as they will be.
constexpr Duration kLensesAreJudged{15'000'000'000}, kIsFound{20'000'000'000};
// It shows in motion only; later, what lenses and IMU do beside their models has added up. And
// after something else was found.
constexpr Duration kMountIsJudged{60'000'000'000}, kMountSettles{10'000'000'000};
// In turn, before something is given room.
constexpr int kLooksAtRough = 2;
// Beside the parameters that were learnt, before which nothing surprises.
constexpr double kNumAsExpected = 3;

CalibrationMatrix BaselineCovariance(const StereoRig& rig, double share) {
  CalibrationVector change = CalibrationVector::Zero();
  change.segment<3>(kStereoTranslation) = share * rig.T_C1C0().p;
  return change * change.transpose();
}

// What uncalibrated rigs have: a data sheet's focal lengths, cameras that were glued by eye, a
// driver's stamps. Added to what a careful calibration leaves, in the part that is wrong only: with
// the baseline free, the size of the world would rest on the accelerometer alone.
CalibrationMatrix RoughCovariance(CalibrationPart part, const StereoRig& rig) {
  constexpr double kBaseline = 0.02;
  constexpr double kTime_s = 0.01;
  CalibrationMatrix covariance = CalibrationMatrix::Zero();
  const auto add = [&](const CalibrationVector& sigmas) {
    covariance += sigmas * sigmas.transpose();
  };
  switch (part) {
    case CalibrationPart::kLenses:
      add(RoughFocalLengths(rig));
      for (const CalibrationVector& error : RoughPlaceErrors(rig))
        add(error);
      break;
    case CalibrationPart::kBaseline:
      covariance = BaselineCovariance(rig, kBaseline);
      break;
    case CalibrationPart::kMount:
      for (const CalibrationVector& error : RoughMountErrors())
        add(error);
      break;
    case CalibrationPart::kClock:
      add(kTime_s * CalibrationVector::Unit(kTimeOffset));
      break;
    case CalibrationPart::kDistortion:
      break;  // has room with all that lenses do, or none
    case CalibrationPart::kGyroscope:
      break;  // soon known far better than before any measurement: it needs no room
  }
  return covariance;
}

bool IsOfLenses(const CalibrationDeviation& deviation) {
  return deviation.part == CalibrationPart::kLenses;
}

// It has room with all that lenses do, or none.
bool IsOfDistortion(const CalibrationDeviation& deviation) {
  return deviation.part == CalibrationPart::kDistortion;
}

// What state and clock have in common is that of the newest keyframe. A frame after it may be known
// better, or turn much faster; then it is less, so that the two still have a joint covariance.
Vector<15> PossibleCovariance(const Matrix<15, 15>& covariance, const ClockCovariance& clock) {
  const Vector<15> inverse_sigma = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix<15, 15> correlation =
      inverse_sigma.asDiagonal() * covariance * inverse_sigma.asDiagonal();
  const Eigen::LLT<Matrix<15, 15>> factor(correlation);
  if (factor.info() != Eigen::Success) return Vector<15>::Zero();
  Vector<15> whitened = inverse_sigma.cwiseProduct(clock.with_newest);
  factor.matrixL().solveInPlace(whitened);
  const double explained = whitened.squaredNorm();
  if (!(explained > clock.variance)) return clock.with_newest;
  return std::sqrt(clock.variance / explained) * clock.with_newest;
}

}  // namespace

double CalibrationSurprise(const CalibrationVector& delta,
                           const CalibrationMatrix& possible,
                           const CalibrationMatrix& left) {
  const Eigen::LDLT<CalibrationMatrix> factor(possible);
  const double squares = delta.dot(CalibrationVector(factor.solve(delta)));
  const double num_learnt = std::max(kNumCalibration - factor.solve(left).trace(), 0.0);
  return (squares + kNumAsExpected) / (num_learnt + kNumAsExpected);
}

CalibrationMatrix LeftWithNoise(double factor,
                                const CalibrationMatrix& possible,
                                const CalibrationMatrix& left) {
  const auto relative = RelativeCovariance<CalibrationMatrix>::Of(possible, left);
  if (!relative) return left;
  // In each direction `share` of the variance is left, so that 1 / share - 1 is what was learnt.
  CalibrationVector share = relative->shares().cwiseMax(kLeastShare);
  for (double& s : share)
    s = s < 1 ? factor * s / (factor * s + 1 - s) : s;
  return relative->WithShares(share);
}

SelfCalibration::SelfCalibration(const StereoRig& rig, const CalibrationOptions& options)
    : rig_(rig), options_(options) {
  if (options.IsHeld()) return;
  start_covariance_ = StartCovariance(rig, options);
  possible_ = *start_covariance_;
  // A former run's covariance has what other groups have in common, and was measured.
  if (!rig.covariance) care_.emplace(*start_covariance_, options);
}

void SelfCalibration::Begin(SlidingWindow& window) {
  if (!start_covariance_) return;
  ForgetMount();
  window.calibration.emplace(rig_, *start_covariance_);
  if (!kept_) return;
  window.calibration->SetDelta(kept_->delta);
  window.calibration->Restart(kept_->covariance);
  possible_ = kept_->possible;
  room_ = kept_->room;
  care_ = kept_->care;
}

void SelfCalibration::TakeClock(const SlidingWindow& window, const WindowSolver& solver) {
  if (window.calibration) clock_ = solver.NewestFrameWithClock();
}

void SelfCalibration::Keep(const SlidingWindow& window, const WindowSolver& solver) {
  if (!window.calibration) return;
  const Timestamp now = window.frames.back().x.t;
  if (is_doubted_ || (kept_ && now - kept_->t < kKeepEvery)) return;
  kept_ = Kept{now,
               window.calibration->delta(),
               possible_,
               solver.CalibrationCovariance(),
               room_,
               care_,
               window.calibration->Refined()};
  surprise_ = CalibrationSurprise(kept_->delta, possible_, kept_->covariance);
  if (!first_kept_) first_kept_ = now;
  if (freed_at_ && now - *freed_at_ < kSettles) return;
  if (room_.lenses && !found_lenses_ && now - *freed_at_ >= kIsFound) found_lenses_ = kept_->delta;
  const auto gross_of = [&](const CalibrationVector& delta) {
    return GrossDeviations(rig_, delta, kept_->covariance, *start_covariance_);
  };
  gross_deviations_ = gross_of(kept_->delta);
  unexpected_ = gross_of(BeyondRoom());
  std::erase_if(unexpected_, IsOfDistortion);
  std::erase_if(gross_deviations_, [&](const auto& d) { return !HasRoom(d.part); });
  AddMount();
}

// Lenses that were found to be wrong may change once more: a focus that is knocked.
CalibrationVector SelfCalibration::BeyondRoom() const {
  CalibrationVector beyond = kept_->delta;
  if (room_.lenses) {
    const CalibrationVector& found = found_lenses_ ? *found_lenses_ : kept_->delta;
    beyond.head<kStereoTranslation>() -= found.head<kStereoTranslation>();
  } else if (room_.focal_lengths) {
    beyond = WithoutCommonFocalLength(rig_, beyond);
  }
  return beyond;
}

void SelfCalibration::Doubt(Timestamp now, bool is_contradicted) {
  if (!is_contradicted) {
    contradicted_since_.reset();
  } else if (!contradicted_since_) {
    contradicted_since_ = now;
  }
  is_doubted_ = is_contradicted && now - *contradicted_since_ < kMaxDoubt;
}

bool SelfCalibration::HasRoom(CalibrationPart part) const {
  if (part == CalibrationPart::kDistortion) return room_.lenses;
  return num_large_steps_[static_cast<std::size_t>(part)] > 0 ||
         (part == CalibrationPart::kLenses && (room_.lenses || room_.focal_lengths));
}

// Each part once, however many things in it are wrong.
std::optional<CalibrationMatrix> SelfCalibration::LargeStep() {
  std::optional<CalibrationMatrix> step;
  std::array<bool, kNumCalibrationParts> is_due{};
  for (const CalibrationDeviation& d : unexpected_) {
    bool& due = is_due[static_cast<std::size_t>(d.part)];
    if (due || NumLargeSteps(d.part) >= kMaxLargeSteps) continue;
    due = true;
    ++NumLargeSteps(d.part);
    if (!step) step = CalibrationMatrix::Zero();
    *step += RoughCovariance(d.part, rig_);
  }
  return step;
}

void SelfCalibration::Walk(SlidingWindow& window) {
  if (!window.calibration) return;
  if (is_doubted_) return ForgetMount();
  const Timestamp now = window.frames.back().x.t;
  const bool has_news = kept_ && judged_ != kept_->t;
  if (has_news) judged_ = kept_->t;
  if (KnowsCalibration(window.prior)) {
    if (has_news) JudgeLenses(window);
    const bool is_settled = !freed_at_ || now - *freed_at_ >= kSettles;
    if (const auto step = is_settled ? LargeStep() : std::nullopt) {
      GiveUpCare(window);
      TakeStep(*step, window);
      unexpected_.clear();
      freed_at_ = now;
    }
    if (has_news) JudgeFocalLengths(window);
    if (has_news) JudgeMount();
  }
  if (doubted_share_ != 0 && options_.lens) {
    GiveUpCare(window);
    TakeStep(BaselineCovariance(rig_, doubted_share_), window);
    doubted_share_ = 0;
  }
  if (has_news) JudgeCare(window);
  if (!last_step_) last_step_ = now;
  if (now - *last_step_ < kStepEvery) return;
  last_step_ = now;
  constexpr double kShare = kStepShare * kStepShare;
  if (!TakeStep(kShare * *start_covariance_, window) || !care_) return;
  care_->AddStep(kShare);
  window.calibration->SettleModes(care_->AreModesSettled());
}

// Soon, or not at all: what comes after a while of good estimates has not always been wrong, and
// takes a large step.
void SelfCalibration::JudgeLenses(SlidingWindow& window) {
  if (!options_.lens || room_.lenses || kept_->t - *first_kept_ > kLensesAreJudged) return;
  const bool are_rough =
      AreLensesRough(rig_, InformationOf(kept_->possible), kept_->delta, kept_->covariance);
  num_looks_at_lenses_ = are_rough ? num_looks_at_lenses_ + 1 : 0;
  if (are_rough) std::erase_if(unexpected_, IsOfLenses);
  if (num_looks_at_lenses_ < kLooksAtRough) return;
  GiveRoom(RoughLensErrors(rig_), window);
  room_.lenses = room_.focal_lengths = true;
}

// Twice in turn, since what has just taken a large step is not yet as it will be.
void SelfCalibration::JudgeFocalLengths(SlidingWindow& window) {
  if (!options_.lens || !options_.gyro || room_.focal_lengths) return;
  const bool are_rough =
      AreFocalLengthsRough(rig_, InformationOf(kept_->possible), kept_->delta, kept_->covariance);
  num_looks_at_focal_lengths_ = are_rough ? num_looks_at_focal_lengths_ + 1 : 0;
  if (num_looks_at_focal_lengths_ < kLooksAtRough) return;
  const CalibrationVector rough = RoughFocalLengths(rig_);
  GiveRoom({&rough, 1}, window);
  room_.focal_lengths = true;
}

void SelfCalibration::ForgetMount() {
  rough_mount_.reset();
  num_looks_at_mount_ = 0;
}

// It is only named: given room by this evidence, slow flights and halls became three times worse
// (docs/notebook/calibration_online.md).
void SelfCalibration::JudgeMount() {
  if (!IsMountJudged()) return ForgetMount();
  rough_mount_.reset();
  auto rough =
      FindRoughMount(rig_, InformationOf(kept_->possible), kept_->delta, kept_->covariance);
  num_looks_at_mount_ = rough ? num_looks_at_mount_ + 1 : 0;
  if (num_looks_at_mount_ >= kLooksAtRough) rough_mount_ = std::move(rough);
}

// Not while something else is being found. What a former run has measured has no size that only a
// rough rig exceeds.
bool SelfCalibration::IsMountJudged() const {
  return options_.mount && !rig_.covariance && !HasRoom(CalibrationPart::kMount) &&
         kept_->t - *first_kept_ <= kMountIsJudged && (room_.lenses || num_looks_at_lenses_ == 0) &&
         (room_.focal_lengths || num_looks_at_focal_lengths_ == 0) &&
         (!freed_at_ || kept_->t - *freed_at_ >= kMountSettles);
}

void SelfCalibration::AddMount() {
  if (!rough_mount_) return;
  for (CalibrationDeviation& d :
       GrossDeviations(rig_, rough_mount_->delta, rough_mount_->left, *start_covariance_)) {
    if (d.part != CalibrationPart::kMount) continue;
    d.what += " (made good in part)";
    gross_deviations_.push_back(std::move(d));
  }
}

// They have always been wrong. So this is as if it had been believed possible from the start, and
// no random step: all that was measured counts.
void SelfCalibration::GiveRoom(std::span<const CalibrationVector> errors, SlidingWindow& window) {
  GiveUpCare(window);
  AddInformation(RoomForErrors(errors, InformationOf(possible_)), window.prior);
  for (const CalibrationVector& error : errors)
    possible_ += error * error.transpose();
  unexpected_.clear();  // it was judged by what was believed before
  freed_at_ = window.frames.back().x.t;
}

void SelfCalibration::GiveUpCare(SlidingWindow& window) {
  if (care_) care_->GiveUp(window.prior, possible_);
  care_.reset();
  window.calibration->SettleModes(false);
}

void SelfCalibration::JudgeCare(SlidingWindow& window) {
  if (!care_) return;
  care_->Judge(kept_->delta, kept_->covariance, window.prior, possible_);
  window.calibration->SettleModes(care_->AreModesSettled());
}

bool SelfCalibration::TakeStep(const CalibrationMatrix& covariance, SlidingWindow& window) {
  if (!TakeRandomStep(covariance, window.prior)) return false;
  possible_ += covariance;
  return true;
}

void SelfCalibration::MoveToImage(const SlidingWindow& window,
                                  const ImageMotion& motion,
                                  EstimatorResult& result) const {
  if (!window.calibration) return;
  NavState& x = result.state;
  const BodyRates rates{motion.w_B, x.T_WB.q.conjugate() * x.v_WB + motion.dv_B};
  const Vector3d dv_W = x.T_WB.q * motion.dv_B;
  x.T_WB = window.calibration->AtImage(x.T_WB, rates);
  Vector<15> moved = Vector<15>::Zero();
  moved.head<3>() = rates.w_B;
  moved.segment<3>(3) = x.v_WB + dv_W;
  const Vector<15> with_clock = PossibleCovariance(result.covariance, clock_);
  const Matrix<15, 15> cross = moved * with_clock.transpose();
  result.covariance += cross + cross.transpose() + clock_.variance * moved * moved.transpose();
  x.v_WB += 2 * dv_W;  // dv_W is the mean on the way
}

std::optional<StereoRig> SelfCalibration::Refined(double noise_factor) const {
  if (!kept_) return std::nullopt;
  StereoRig rig = kept_->rig;
  rig.covariance = std::make_shared<const MatrixXd>(
      LeftWithNoise(noise_factor, kept_->possible, kept_->covariance));
  rig.axes_sigma = options_.mount ? options_.AxesSigma() : 0;
  return rig;
}

}  // namespace facet
