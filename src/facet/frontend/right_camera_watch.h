// SPDX-License-Identifier: BSD-2-Clause
// Notices, while a run goes on, that the right camera has been turned in its mount: far fewer
// tracks than usual have their match on the epipolar line, and matches beside it agree on a turn.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "facet/base/types.h"
#include "facet/frontend/stereo_turn.h"

namespace facet {

/// Not thread-safe.
class RightCameraWatch {
 public:
  /// What a keyframe has found, `num_near` of them well within the gate. True: that is suspiciously
  /// little, and Add wants the matches of a wide gate.
  bool IsSuspicious(Timestamp t, int num_tracks, int num_near);

  /// The wide matches of a suspicious keyframe. The turn, once all keyframes of a second show one
  /// and it is clear; the caller corrects it, and `rig` contains it from then on.
  std::optional<StereoTurn> Add(Timestamp t,
                                const StereoRig& rig,
                                std::span<const StereoRays> matches);

  /// The rig is another one from now on: matches of before say nothing of it.
  void Forget() {
    matches_.clear();
    num_in_row_ = 0;
  }

  /// Nothing was suspicious for some seconds.
  bool IsTrustedAt(Timestamp t) const;

 private:
  std::optional<Timestamp> last_suspicious_;
  // Of the tracks, near their epipolar lines. Good recordings have more from the first keyframe on.
  double usual_share_ = 0.4;
  Timestamp begin_, last_in_row_;  // of the keyframes in a row
  int num_in_row_ = 0;             // suspicious ones
  int num_to_pass_ = 0;            // keyframes, after a look in vain
  std::vector<StereoRays> matches_;
};

}  // namespace facet
