// SPDX-License-Identifier: BSD-2-Clause
#include "facet/check/stamp_beat.h"

#include <cmath>

namespace facet {
namespace {

constexpr std::size_t kNumToLearn = 1000;
// Longer intervals tell nothing of jitter.
constexpr double kLongestRegular = 3.5;

}  // namespace

void StampBeat::Add(Timestamp t) {
  ++num_;
  if (last_) {
    if (is_median_known_) {
      Judge(*last_, t);
    } else {
      first_.push_back({*last_, t});
      if (first_.size() == kNumToLearn) End();
    }
  }
  last_ = t;
}

void StampBeat::End() {
  if (is_median_known_ || first_.empty()) return;
  std::vector<double> intervals;
  for (const Span& span : first_)
    intervals.push_back(ToSeconds(span.to - span.from));
  median_s_ = MedianOf(intervals);
  is_median_known_ = true;
  for (const Span& span : first_)
    Judge(span.from, span.to);
  first_.clear();
}

void StampBeat::Judge(Timestamp from, Timestamp to) {
  const double interval_s = ToSeconds(to - from);
  if (interval_s >= gap_s_ && interval_s > 1.5 * median_s_) {
    ++num_gaps_;
    if (!longest_gap_ || interval_s > ToSeconds(longest_gap_->to - longest_gap_->from))
      longest_gap_ = Span{from, to};
    return;
  }
  covered_s_ += interval_s;
  ++num_intervals_;
  if (interval_s > kLongestRegular * median_s_) return;
  const double beats = std::max(1.0, std::round(interval_s / median_s_));
  const double deviation_s = interval_s - beats * median_s_;
  squares_ += deviation_s * deviation_s;
  ++num_regular_;
}

double StampBeat::jitter_s() const {
  return num_regular_ == 0 ? 0 : std::sqrt(0.5 * squares_ / num_regular_);
}

double StampBeat::missing_share() const {
  if (covered_s_ <= 0) return 0;
  return std::max(0.0, 1 - num_intervals_ * median_s_ / covered_s_);
}

}  // namespace facet
