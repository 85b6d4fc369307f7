// SPDX-License-Identifier: BSD-2-Clause
#include "facet/imu/imu_screen.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "facet/base/median.h"

namespace facet {

namespace {

constexpr double kJumpInUsualChanges = 40;
constexpr std::size_t kNumToConfirm = 5;

// A single sample that is further off the line between its neighbours than these are from each
// other. In clean recordings it is at most four times the gyroscope's usual change, and six times
// the accelerometer's only where it is less than 3.7 m/s^2 (docs/notebook/faults.md).
constexpr double kGyroSpike = 0.3;  // rad/s
constexpr double kAccelSpike = 4;   // m/s^2
constexpr double kSpikeInUsualChanges = 6;
// Before it is known what is usual.
constexpr double kGyroSpikeAtFirst = 0.6;  // rad/s
constexpr double kAccelSpikeAtFirst = 9;   // m/s^2
// Propellers may shake every other sample to the other side. Such a vibration swells, so that the
// change before the sample is nearly as large; before a glitch it is not.
constexpr double kSpikeInLastChanges = 2;

// Of noisy samples four in a row are not equal by chance where they would also have to be the
// largest ones.
constexpr int kNumEqual = 4;
// A turning point is reached slowly, the end of the range is not.
constexpr double kLeastChangeIntoLimit = 0.25;  // of the usual change
constexpr double kAtLimit = 0.999;  // the two ends of a range differ by one digit or two
// How far beyond its range the true value may be, on average over the stay there.
constexpr double kExcessOfRange = 0.25;

// What a sensor that repeats itself may have missed.
constexpr double kGyroOfRepeated = 0.3;  // rad/s
constexpr double kAccelOfRepeated = 3;   // m/s^2
// One sensor alone may come at a lower rate and be sent again in between, but no slower than that.
constexpr double kLongestRepeat_s = 0.05;
// An accelerometer that stands still near nothing is dead, and gravity is what it misses.
constexpr double kDeadAccel = 0.1;  // m/s^2

bool AreEqual(const ImuSample& a, const ImuSample& b) {
  return a.gyro == b.gyro && a.accel == b.accel;
}

/// The error is the same for all of a stay of `num_now` samples: the variance that the newest one
/// adds, so that the steps together have a standard deviation that grows with their number, as if
/// they were not independent. The stay's first samples were not doubted when they came.
double GrowingSigma(double sigma, int num_now, int num_doubted) {
  return sigma * std::sqrt(static_cast<double>(num_now) * num_now -
                           static_cast<double>(num_doubted) * num_doubted);
}

}  // namespace

void UsualChange::Add(double change) {
  // A sensor with noise that repeats itself has failed, which is not usual.
  if (change == 0 && value_ > 0) return;
  changes_[num_ % kNumKept] = change;
  ++num_;
  if (num_ % kNumBetweenUpdates != 0) return;
  std::array<double, kNumKept> sorted = changes_;
  value_ = Median(std::span(sorted).first(std::min(num_, kNumKept))).value_or(0);
}

int SaturationWatch::Add(double x, double usual_change) {
  if (run_ > 0 && x == previous_) {
    ++run_;
  } else {
    change_into_run_ = run_ > 0 ? std::abs(x - previous_) : 0;
    run_ = 1;
  }
  previous_ = x;
  const double size = std::abs(x);
  if (size * kAtLimit > limit_) limit_ = std::numeric_limits<double>::infinity();
  largest_ = std::max(largest_, size);
  if (run_ >= kNumEqual && size >= largest_ && size > least_ && usual_change > 0 &&
      change_into_run_ > kLeastChangeIntoLimit * usual_change &&
      change_into_run_ <= std::max(jump_, kJumpInUsualChanges * usual_change)) {
    limit_ = size;
    num_at_limit_ = std::max(num_at_limit_, run_ - 1);
  }
  num_at_limit_ = size >= kAtLimit * limit_ ? num_at_limit_ + 1 : 0;
  return num_at_limit_;
}

void ImuScreen::Add(const ImuSample& sample, std::deque<ImuSample>& samples) {
  ImuSample doubted = sample;
  DoubtSaturated(doubted);
  DoubtRepeated(doubted);
  DoubtFrozenSensor(doubted);
  DoubtStuckAxes(doubted);
  newest_ = sample;
  if (samples.empty() || !IsJump(samples.back(), sample, TimeToNext(samples.back(), sample))) {
    counts_.num_cut += static_cast<int>(held_back_.size());
    held_back_.clear();
    Accept(doubted, samples);
    return;
  }
  if (!held_back_.empty() &&
      IsJump(held_back_.back(), sample, ToSeconds(sample.t - held_back_.back().t))) {
    counts_.num_cut += static_cast<int>(held_back_.size());
    held_back_.clear();
  }
  if (StandsStill(samples.back(), sample)) {
    ++counts_.num_cut;
    return;
  }
  held_back_.push_back(doubted);
  if (held_back_.size() < kNumToConfirm) return;
  // If nothing else had been seen before the jump, the first sample was the glitch.
  if (num_accepted_ == 1 && samples.size() == 1) {
    samples.clear();
    ++counts_.num_cut;
  }
  for (const ImuSample& confirmed : held_back_)
    Accept(confirmed, samples);
  held_back_.clear();
}

void ImuScreen::DoubtSaturated(ImuSample& sample) {
  bool is_saturated = false;
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    const auto axis = static_cast<Eigen::Index>(i % 3);
    const bool is_gyro = i < 3;
    const double usual = is_gyro ? gyro_change_.value() : accel_change_.value();
    const int stay = watches_[i].Add(is_gyro ? sample.gyro[axis] : sample.accel[axis], usual);
    if (stay > 0) {
      const double sigma = kExcessOfRange * watches_[i].limit();
      (is_gyro ? sample.gyro_doubt : sample.accel_doubt)[axis] =
          GrowingSigma(sigma, stay, num_doubted_[i]);
      is_saturated = true;
    }
    num_doubted_[i] = stay;
  }
  counts_.num_saturated += is_saturated ? 1 : 0;
}

void ImuScreen::DoubtRepeated(ImuSample& sample) {
  // A simulated sensor without noise repeats itself at rest, and has no usual change.
  const bool repeats = newest_ && AreEqual(*newest_, sample) && gyro_change_.value() > 0;
  num_repeats_ = repeats ? num_repeats_ + 1 : 0;
  if (num_repeats_ + 1 < kNumEqual) return;
  ++counts_.num_repeated;
  const int num_doubted = num_repeats_ + 1 == kNumEqual ? 0 : num_repeats_ - 1;
  const double growth = GrowingSigma(1, num_repeats_, num_doubted);
  sample.gyro_doubt = sample.gyro_doubt.cwiseMax(growth * kGyroOfRepeated);
  sample.accel_doubt = sample.accel_doubt.cwiseMax(growth * kAccelOfRepeated);
}

// Both at once are DoubtRepeated's.
void ImuScreen::DoubtFrozenSensor(ImuSample& sample) {
  const double dt_s = newest_ ? ToSeconds(sample.t - newest_->t) : 0;
  const auto doubt = [&](bool repeats, double usual_change, double sigma, Stay& stay) -> double {
    if (!repeats || !(usual_change > 0)) {
      stay = {};
      return 0;
    }
    ++stay.num_repeats;
    stay.duration_s += dt_s;
    if (stay.duration_s < kLongestRepeat_s || num_repeats_ + 1 >= kNumEqual) return 0;
    const double growing = GrowingSigma(sigma, stay.num_repeats, stay.num_doubted);
    stay.num_doubted = stay.num_repeats;
    return growing;
  };
  const bool gyro_repeats = newest_ && newest_->gyro == sample.gyro;
  const bool accel_repeats = newest_ && newest_->accel == sample.accel;
  const double gyro = doubt(gyro_repeats, gyro_change_.value(), kGyroOfRepeated, gyro_stay_);
  const double accel = doubt(accel_repeats,
                             accel_change_.value(),
                             sample.accel.norm() < kDeadAccel ? kGravity : kAccelOfRepeated,
                             accel_stay_);
  sample.gyro_doubt = sample.gyro_doubt.cwiseMax(gyro);
  sample.accel_doubt = sample.accel_doubt.cwiseMax(accel);
  counts_.num_repeated += gyro > 0 || accel > 0 ? 1 : 0;
}

// What is doubted already, because the axis is at the end of its range or all of the sensor stands
// still, is not doubted once more.
void ImuScreen::DoubtStuckAxes(ImuSample& sample) {
  if (!newest_) return;
  const double dt_s = ToSeconds(sample.t - newest_->t);
  bool is_stuck = false;
  for (std::size_t i = 0; i < stuck_.size(); ++i) {
    const bool is_gyro = i < 3;
    const Vector3d& now = is_gyro ? sample.gyro : sample.accel;
    const Vector3d& before = is_gyro ? newest_->gyro : newest_->accel;
    double& doubt =
        (is_gyro ? sample.gyro_doubt : sample.accel_doubt)[static_cast<Eigen::Index>(i % 3)];
    const auto change = [&](std::size_t k) {
      const auto axis = static_cast<Eigen::Index>(k % 3);
      return now[axis] - before[axis];
    };
    const int stay = stuck_[i].Add(dt_s, change(i), {change(i + 1), change(i + 2)});
    if (stay > 0 && doubt == 0) {
      const double sigma = is_gyro ? kGyroOfRepeated : kAccelOfRepeated;
      doubt = GrowingSigma(sigma, stay, num_doubted_stuck_[i]);
      is_stuck = true;
    }
    num_doubted_stuck_[i] = stay;
  }
  counts_.num_repeated += is_stuck ? 1 : 0;
}

bool ImuScreen::StandsStill(const ImuSample& believed, const ImuSample& sample) const {
  if (held_back_.empty()) return false;
  const auto stands = [](const Vector3d& from, const Vector3d& held, const Vector3d& to) {
    Eigen::Index axis = 0;
    (to - from).cwiseAbs().maxCoeff(&axis);
    return to[axis] == held[axis] && to[axis] != from[axis];
  };
  const bool gyro_jumps = IsGyroJump(believed, sample, TimeToNext(believed, sample));
  return gyro_jumps ? stands(believed.gyro, held_back_.back().gyro, sample.gyro)
                    : stands(believed.accel, held_back_.back().accel, sample.accel);
}

void ImuScreen::Accept(const ImuSample& sample, std::deque<ImuSample>& samples) {
  if (samples.size() >= 3 && IsSpike(samples, sample)) {
    samples.pop_back();
    ++counts_.num_cut;
  }
  if (!samples.empty()) {
    gyro_change_.Add((sample.gyro - samples.back().gyro).norm());
    accel_change_.Add((sample.accel - samples.back().accel).norm());
  }
  samples.push_back(sample);
  ++num_accepted_;
}

// Samples that are held back make no hole: over one, much may change.
double ImuScreen::TimeToNext(const ImuSample& accepted, const ImuSample& sample) const {
  return ToSeconds((held_back_.empty() ? sample : held_back_.front()).t - accepted.t);
}

bool ImuScreen::IsGyroJump(const ImuSample& from, const ImuSample& to, double dt_s) const {
  const double dt = std::max(dt_s, kShortestStep_s);
  return (to.gyro - from.gyro).norm() >
         std::max(kGyroJump * dt, kJumpInUsualChanges * gyro_change_.value());
}

bool ImuScreen::IsJump(const ImuSample& from, const ImuSample& to, double dt_s) const {
  const double dt = std::max(dt_s, kShortestStep_s);
  return IsGyroJump(from, to, dt_s) ||
         (to.accel - from.accel).norm() >
             std::max(kAccelJump * dt, kJumpInUsualChanges * accel_change_.value());
}

bool ImuScreen::IsSpike(const std::deque<ImuSample>& samples, const ImuSample& after) const {
  const std::size_t newest = samples.size() - 1;
  const ImuSample& sample = samples[newest];
  const ImuSample& before = samples[newest - 1];
  const ImuSample& long_before = samples[newest - 2];
  const auto is_spike = [&](Vector3d ImuSample::*sensor, double least, double usual_change) {
    const Vector3d &a = before.*sensor, &x = sample.*sensor, &b = after.*sensor;
    const double last_change = (a - long_before.*sensor).norm();
    return (x - 0.5 * (a + b)).norm() - (b - a).norm() >
           std::max(
               {least, kSpikeInUsualChanges * usual_change, kSpikeInLastChanges * last_change});
  };
  const double gyro_change = gyro_change_.value(), accel_change = accel_change_.value();
  // Between the samples of a slow sensor more may happen.
  const double dt_s = 0.5 * ToSeconds(after.t - before.t);
  const double slowness = std::max(1.0, dt_s / kShortestStep_s);
  const double least_gyro = gyro_change > 0 ? kGyroSpike : kGyroSpikeAtFirst;
  const double least_accel = accel_change > 0 ? kAccelSpike : kAccelSpikeAtFirst;
  return is_spike(&ImuSample::gyro, slowness * least_gyro, gyro_change) ||
         is_spike(&ImuSample::accel, slowness * least_accel, accel_change);
}

}  // namespace facet
