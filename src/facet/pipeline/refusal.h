// SPDX-License-Identifier: BSD-2-Clause
// The two kinds of refusals (VioOutput::refusal): of a calibration, and of a dead sensor.
#pragma once

namespace facet {

/// With what a refusal begins that is about the calibration.
inline constexpr const char* kWrongCalibration = "the calibration cannot be right: ";

}  // namespace facet
