// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

namespace facet {

/// What `facet info` is told on the command line.
struct InfoArguments {
  std::string recording, calibration, imu_calibration;
  std::vector<std::string> topics;  // role=name
};

/// `facet info`: what is in a recording, on the standard output. Reads all of it and decodes one
/// image per camera. Throws InputError, behind what could be read, for a damaged one.
void InfoCommand(const InfoArguments& arguments);

}  // namespace facet
