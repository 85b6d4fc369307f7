// SPDX-License-Identifier: BSD-2-Clause
// Holds IMU samples and cuts them at image stamps.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "facet/imu/imu_screen.h"
#include "facet/imu/imu_types.h"

namespace facet {

/// Result of ImuBuffer::Between.
struct ImuInterval {
  std::vector<ImuSample> samples;  ///< first at t0, last at t1 (interpolated); empty if not covered
  /// Holes between samples that turn out to be longer than the allowed gap in [t0, t1]: one that
  /// spans several intervals is counted once.
  int gaps = 0;
  /// Longest time between two samples that overlaps [t0, t1], as far as it is known at t1.
  Duration longest_gap;
  bool has_hole = false;             ///< longest_gap is longer than allowed
  Duration allowed_gap{21'000'000};  ///< a longer step between two samples is a hole
};

/// Not thread-safe. Accepts any content: what is not finite, not in order or a duplicate is
/// refused; what contradicts the samples around it is cut out (ImuScreen). A stamp that is far
/// ahead waits until samples that follow it, or another sensor (TimeIsAt), show that the time has
/// come there; if the samples go on from before instead, it is left out.
class ImuBuffer {
 public:
  /// kNotFinite: not a number, or beyond kMaxMagnitude (its squares would soon overflow).
  enum class AddResult { kAdded, kNotFinite, kNotInOrder };

  /// Far beyond any sensor, in rad/s as well as in m/s^2.
  static constexpr double kMaxMagnitude = 1e5;

  AddResult Add(const ImuSample& sample);

  /// Another sensor's clock says that it is t, in the IMU's time: what was measured up to then need
  /// not wait for confirmation. Call it before Between for an interval that ends at t.
  void TimeIsAt(Timestamp t);

  /// Samples that were left out because their stamps were far ahead of the samples around them.
  int num_stray() const { return num_stray_; }

  /// What was cut out or doubted.
  const ImuScreenCounts& screen_counts() const { return screen_.counts(); }

  /// A step between samples is a hole if it is longer than `max_gap` and than one and a half times
  /// the usual step: a slow sensor has no holes.
  ///
  /// Samples of [t0, t1], linearly interpolated at both ends. Where the buffer, or what was known
  /// of it at t1, ends before t1 by at most `max_extrapolation` (or one and a half times the usual
  /// step, if that is longer) the last sample is held; otherwise, or where the buffer begins after
  /// t0 or t1 < t0, `samples` is empty. What comes after a hole that contains t1 is not used: it is
  /// the future. One sample if t0 == t1.
  ImuInterval Between(Timestamp t0,
                      Timestamp t1,
                      Duration max_gap,
                      Duration max_extrapolation) const;

  /// Forgets what is older than t, but keeps one sample at or before t.
  void DropBefore(Timestamp t);

  /// One and a half times the median step of the last samples, at most 0.15 s; zero before there
  /// are two of them.
  Duration LongestUsualStep() const;

  /// What is believed so far and not dropped, in order of time. The newest one may be taken back
  /// when the next one comes (ImuScreen).
  const std::deque<ImuSample>& samples() const { return samples_; }

  bool empty() const { return samples_.empty(); }
  std::size_t size() const { return samples_.size(); }
  Timestamp first_stamp() const { return samples_.front().t; }
  Timestamp last_stamp() const { return samples_.back().t; }
  /// The same with the samples that wait for confirmation.
  Timestamp newest_stamp() const { return waiting_.empty() ? last_stamp() : waiting_.back().t; }

 private:
  void Take(const ImuSample& sample);
  void Wait(const ImuSample& sample);
  void TakeWaiting();
  void LeaveOutWaiting();

  std::deque<ImuSample> samples_;
  ImuScreen screen_;
  std::optional<Timestamp> newest_;  // of all samples that were taken
  std::vector<ImuSample> waiting_;   // behind a step that is no clock's, in order
  int num_stray_ = 0;
  std::deque<double> steps_s_;  // between the newest samples, also those that were dropped since
};

}  // namespace facet
