// SPDX-License-Identifier: BSD-2-Clause
// The parameters of a calibration that a run holds or estimates together.
#pragma once

#include <array>

#include "facet/camera/rig_columns.h"

namespace facet {

struct CalibrationGroup {
  int first;
  int size;
};

/// Lenses and stereo pair, modes of the lenses, mount, clock, scale of the gyroscope.
inline constexpr std::array<CalibrationGroup, 5> kCalibrationGroups = {
    {{0, kNumRigParameters},
     {kLensModes, 2 * kNumLensModes},
     {kMountRotation, 6},
     {kTimeOffset, 1},
     {kGyroScale, 3}}};

}  // namespace facet
