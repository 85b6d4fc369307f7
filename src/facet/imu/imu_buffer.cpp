// SPDX-License-Identifier: BSD-2-Clause
#include "facet/imu/imu_buffer.h"

#include <algorithm>
#include <array>
#include <span>

#include "facet/base/median.h"

namespace facet {

namespace {

// So many steps that a second of damage hardly moves their median.
constexpr std::size_t kNumSteps = 200;
constexpr double kUsualSteps = 1.5;
// Whatever the sensor does: a longer step is a hole.
constexpr double kLongestStep_s = 0.15;
// After a longer step a stamp may be wrong. It is right when so many samples go on from there: a
// tenth of a second of a usual sensor, longer than damage to a bus or a driver's buffer lasts.
constexpr double kLongestCertainStep_s = kLongestStep_s;
constexpr std::size_t kNumToConfirm = 20;

bool IsUsable(const Vector3d& x) {
  // The comparison is false for NaN.
  return (x.array().abs() <= ImuBuffer::kMaxMagnitude).all();
}

/// The measurement at t on the line through a and b; a.t <= t <= b.t, a.t < b.t.
ImuSample Interpolate(const ImuSample& a, const ImuSample& b, Timestamp t) {
  const double u = ToSeconds(t - a.t) / ToSeconds(b.t - a.t);
  return {t,
          (1 - u) * a.gyro + u * b.gyro,
          (1 - u) * a.accel + u * b.accel,
          b.gyro_doubt,
          b.accel_doubt};
}

}  // namespace

ImuBuffer::AddResult ImuBuffer::Add(const ImuSample& sample) {
  if (!IsUsable(sample.gyro) || !IsUsable(sample.accel)) return AddResult::kNotFinite;
  // The only sample so far may have been the wrong one.
  if (newest_ && steps_s_.empty() && ToSeconds(*newest_ - sample.t) > kLongestCertainStep_s) {
    samples_.clear();
    screen_ = ImuScreen();
    newest_.reset();
    num_stray_ += 1 + static_cast<int>(waiting_.size());
    waiting_.clear();
  }
  if (newest_ && sample.t <= *newest_) return AddResult::kNotInOrder;
  if (newest_ && ToSeconds(sample.t - *newest_) > kLongestCertainStep_s) {
    Wait(sample);
  } else {
    LeaveOutWaiting();
    Take(sample);
  }
  return AddResult::kAdded;
}

void ImuBuffer::TimeIsAt(Timestamp t) {
  if (!waiting_.empty() && waiting_.front().t <= t) TakeWaiting();
}

void ImuBuffer::Take(const ImuSample& sample) {
  if (newest_) steps_s_.push_back(ToSeconds(sample.t - *newest_));
  if (steps_s_.size() > kNumSteps) steps_s_.pop_front();
  newest_ = sample.t;
  screen_.Add(sample, samples_);
}

void ImuBuffer::Wait(const ImuSample& sample) {
  const bool goes_on = !waiting_.empty() && sample.t > waiting_.back().t &&
                       ToSeconds(sample.t - waiting_.back().t) <= kLongestCertainStep_s;
  if (!goes_on) LeaveOutWaiting();
  waiting_.push_back(sample);
  if (waiting_.size() >= kNumToConfirm) TakeWaiting();
}

void ImuBuffer::TakeWaiting() {
  for (const ImuSample& sample : waiting_)
    Take(sample);
  waiting_.clear();
}

void ImuBuffer::LeaveOutWaiting() {
  num_stray_ += static_cast<int>(waiting_.size());
  waiting_.clear();
}

ImuInterval ImuBuffer::Between(Timestamp t0,
                               Timestamp t1,
                               Duration max_gap,
                               Duration max_extrapolation) const {
  ImuInterval result;
  if (samples_.empty() || t1 < t0 || t0 < samples_.front().t) return result;
  const Duration usual = LongestUsualStep();
  max_gap = std::max(max_gap, usual);
  max_extrapolation = std::max(max_extrapolation, usual);
  result.allowed_gap = max_gap;
  // The first sample after t; samples_.front() is never after t0.
  const auto after = [this](Timestamp t) {
    return std::upper_bound(
        samples_.begin(), samples_.end(), t, [](Timestamp stamp, const ImuSample& s) {
          return stamp < s.t;
        });
  };
  // Whether the next sample may be used at t <= t1: what comes after a hole is not known at t1 yet.
  const auto is_known = [&](std::deque<ImuSample>::const_iterator next) {
    return next != samples_.end() && (next->t <= t1 || next->t - std::prev(next)->t <= max_gap);
  };
  const auto sample_at = [&](Timestamp t) {
    const auto next = after(t);
    const ImuSample& previous = *std::prev(next);
    if (is_known(next)) return Interpolate(previous, *next, t);
    return ImuSample{t, previous.gyro, previous.accel, previous.gyro_doubt, previous.accel_doubt};
  };

  Timestamp previous = std::prev(after(t0))->t;
  for (auto it = after(t0); previous < t1; ++it) {
    const bool held = !is_known(it);
    const Duration hole = (held ? t1 : it->t) - previous;
    result.longest_gap = std::max(result.longest_gap, hole);
    result.has_hole = result.longest_gap > max_gap;
    if (hole > max_gap && t0 - previous <= max_gap) ++result.gaps;
    if (held) {
      if (hole > max_extrapolation) return result;
      break;
    }
    previous = it->t;
  }

  result.samples.push_back(sample_at(t0));
  for (auto it = after(t0); it != samples_.end() && it->t < t1; ++it) {
    result.samples.push_back(*it);
  }
  if (t1 > t0) result.samples.push_back(sample_at(t1));
  return result;
}

Duration ImuBuffer::LongestUsualStep() const {
  std::array<double, kNumSteps> steps_s{};
  std::copy(steps_s_.begin(), steps_s_.end(), steps_s.begin());
  const double usual_s = Median(std::span(steps_s).first(steps_s_.size())).value_or(0);
  return FromSeconds(std::min(kUsualSteps * usual_s, kLongestStep_s));
}

void ImuBuffer::DropBefore(Timestamp t) {
  while (samples_.size() > 1 && samples_[1].t <= t)
    samples_.pop_front();
}

}  // namespace facet
