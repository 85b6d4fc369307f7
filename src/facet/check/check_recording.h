// SPDX-License-Identifier: BSD-2-Clause
// Says what is wrong with a recording and its calibration, without an estimator and without ground
// truth.
#pragma once

#include <functional>

#include "facet/check/finding.h"
#include "facet/recording/recording.h"

namespace facet {

/// Reads the recording once, from its beginning; of long ones, only a part of the images is
/// decoded. Damage ends the reading and becomes a finding; nothing is thrown for what the recording
/// holds. `progress` gets the number of frames so far and about how many there are.
CheckReport CheckRecording(Recording& recording,
                           const std::function<void(int, int)>& progress = {});

}  // namespace facet
