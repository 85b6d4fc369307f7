// SPDX-License-Identifier: BSD-2-Clause
// The beat of a stream: its usual interval, gaps, single events that are missing, jitter.
#pragma once

#include <optional>
#include <vector>

#include "facet/check/finding.h"

namespace facet {

/// The usual interval is the median of the first thousand. Not thread-safe.
class StampBeat {
 public:
  /// `gap_s`: an interval of at least this is a gap.
  explicit StampBeat(double gap_s) : gap_s_(gap_s) {}

  void Add(Timestamp t);
  /// No more come.
  void End();

  int num() const { return num_; }
  double median_s() const { return median_s_; }  ///< 0: not known
  double jitter_s() const;       ///< of a stamp, 1-sigma, against a regular beat between neighbours
  double missing_share() const;  ///< of single events, outside of gaps
  int num_gaps() const { return num_gaps_; }
  const std::optional<Span>& longest_gap() const { return longest_gap_; }

 private:
  void Judge(Timestamp from, Timestamp to);

  double gap_s_;
  int num_ = 0;
  std::optional<Timestamp> last_;
  std::vector<Span> first_;  // intervals before the usual one is known
  bool is_median_known_ = false;
  double median_s_ = 0;
  double covered_s_ = 0;  // by intervals that are no gaps
  int num_intervals_ = 0, num_gaps_ = 0, num_regular_ = 0;
  double squares_ = 0;  // of deviations of the intervals
  std::optional<Span> longest_gap_;
};

}  // namespace facet
