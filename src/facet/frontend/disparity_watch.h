// SPDX-License-Identifier: BSD-2-Clause
// Left against right: do the disparities of a keyframe agree with the depths that were known
// before? All of them are off by the same angle where the right image is of another moment, and
// from then on where the right camera has been turned along its epipolar lines, which matches alone
// cannot show.
#pragma once

#include <optional>
#include <vector>

#include "facet/base/types.h"

namespace facet {

/// Of the tracks whose depth was known and that have a match.
struct DisparityShift {
  int num = 0;
  int num_agreeing = 0;  ///< that are about where their depth puts them
  double angle = 0;      ///< by which the right camera would have to be turned [rad]; median
  double spread = 0;     ///< median distance from it [rad]
};

/// Not thread-safe.
class DisparityWatch {
 public:
  enum class Verdict {
    kAgrees,
    kScatters,     ///< in doubt: they agree with the depths as little as with each other
    kContradicts,  ///< all are off by the same; this right image had better not be used
    kTurned,       ///< all of a second agree on `turn`; the caller corrects it
  };

  /// `focal_px`: pixels per radian, which the noise of matches has to do with.
  explicit DisparityWatch(double focal_px) : focal_px_(focal_px) {}

  /// `in_doubt`: far fewer matches than usual were found of late. Then most of them may be of other
  /// points, and depths that were known before are believed rather than they.
  Verdict Add(Timestamp t, const DisparityShift& shift, bool in_doubt);

  /// The calibration has changed at this time. What was usual before says nothing, and until depths
  /// have followed, for some seconds, they contradict nothing.
  void Forget(Timestamp t);

  /// In doubt: half of them agree with the depths, or there are too few to say so.
  static bool AreBelieved(const DisparityShift& shift);

  /// After kTurned [rad].
  double turn() const { return turn_; }

 private:
  double focal_px_;
  double usual_angle_ = 0;            // calibrations that are a little wrong have one
  std::optional<Timestamp> changed_;  // the calibration, last
  Timestamp begin_, last_;            // of the contradicting ones
  std::vector<double> contradicting_;
  double turn_ = 0;
  int num_to_pass_ = 0;  // keyframes, after contradictions that do not agree with each other
};

}  // namespace facet
