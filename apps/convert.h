// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

namespace facet {

/// What `facet convert` is told on the command line.
struct ConvertArguments {
  std::string recording, out, calibration, imu_calibration;
  std::vector<std::string> topics;  // role=name
  bool quiet = false;
};

/// `facet convert`: writes a recording as a folder in the ASL layout: images as 8-bit grey PNG, the
/// IMU, and the calibration (Kalibr's format) if there is one. Images that are there already are
/// kept, so that a conversion that was interrupted goes on; the lists are written last. Throws
/// InputError, OutputError, and ConfigError where OUT is something else.
void ConvertCommand(const ConvertArguments& arguments);

}  // namespace facet
