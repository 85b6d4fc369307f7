// SPDX-License-Identifier: BSD-2-Clause
// Which side is believed when landmarks and the IMU disagree about how a frame has moved.
#pragma once

#include <optional>
#include <vector>

#include "facet/base/types.h"
#include "facet/estimator/solver/frame_update.h"
#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// What moves on its own contradicts the IMU, and so does everything if the IMU is wrong. Landmarks
/// that have agreed with the IMU before are the witnesses: things that come into view while moving
/// do not become any, however much of the image they fill, unless they are so slow that they agree;
/// an IMU that fails contradicts all witnesses at once. docs/math.md, section 4.5. Not thread-safe.
class InnovationJudge {
 public:
  /// Whether what contradicts the IMU is to be left out of the frame at `t`; otherwise all of it is
  /// to be used. Stamps must not decrease.
  bool LeavesOut(const InnovationTest& test, Timestamp t);

 private:
  std::optional<Timestamp> t_confirmed_;  // when witnesses last agreed with the IMU
};

/// Counts for every landmark the keyframes at which it agreed with the IMU, anew after one at which
/// it did not: some of what moves seems to stand still now and then.
void Remember(const InnovationTest& test,
              const std::vector<PreparedObservation>& observations,
              SlidingWindow& window);

/// Removes what contradicts the IMU, or has lately; where most of what is no witness contradicts,
/// also the rest of that, which agrees by chance.
void LeaveOutMoving(const InnovationTest& test,
                    SlidingWindow& window,
                    std::vector<PreparedObservation>& observations);

}  // namespace facet
