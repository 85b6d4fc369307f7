// SPDX-License-Identifier: BSD-2-Clause
// What goes wrong with sensors and calibrations, planted in a recording. Detectors never see which
// fault it was: the result is a recording like any other.
#pragma once

#include <string>

#include "facet/faults/recording_copy.h"

namespace facet {

/// Plants a fault: "name" or "name:parameter=value,...", as ListFaults names them. Throws
/// ConfigError with what is known if the name, a parameter or a value is not.
void PlantFault(const std::string& fault, RecordingCopy& recording);

/// One line for each fault: name, parameters with their defaults, meaning.
std::string ListFaults();

}  // namespace facet
