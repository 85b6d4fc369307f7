// SPDX-License-Identifier: BSD-2-Clause
// The frames of a part of a recording, each with the IMU samples that come before it.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "run_sequence.h"

#include "facet/recording/recording.h"

namespace facet {

/// A frame and the IMU samples that come before it.
struct RunStep {
  std::vector<ImuSample> imu;
  RecordedFrame frame;
};

/// Reads the chosen part of a recording, one frame after the other. The recording must be at its
/// beginning and have a calibration.
class StepReader {
 public:
  StepReader(Recording& recording, const RunRange& range) : recording_(recording), range_(range) {}

  /// Steps over what comes before the part; false when no stereo pair is in it. Of the samples from
  /// before the first frame (or from before the wanted history of it), the last one stays.
  bool FindFirst(RunStep& step);

  /// False at the end of the part.
  bool Next(RunStep& step);

  /// What is wrong after FindFirst has found nothing: throws InputError where the recording is
  /// damaged, else ConfigError, for which it reads on to see how long the recording is.
  [[noreturn]] void ThrowNoPair();

  int NumFramesFrom(Timestamp first) const;

  const std::string& damage() const { return damage_; }  ///< where reading ended; empty: nowhere

 private:
  double LengthSeconds();
  double SecondsOf(Timestamp t) const { return ToSeconds(t - *origin_); }
  bool IsBehind(Timestamp t) const;
  std::optional<RecordingEvent> NextEvent();
  void DropEarly(std::deque<ImuSample>& imu, Timestamp frame) const;

  Recording& recording_;
  const RunRange range_;
  std::optional<Timestamp> origin_;  // the first stereo pair of the recording
  Timestamp last_;
  std::string damage_;
};

}  // namespace facet
