// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

namespace facet {

/// What `facet check` is told on the command line.
struct CheckArguments {
  std::string recording, calibration, imu_calibration, json;
  std::vector<std::string> topics;  // role=name
  bool quiet = false;
};

/// `facet check`: what is wrong with a recording and its calibration, on the standard output.
/// Throws InputError, behind the report, if anything is; and for a recording that cannot be opened.
void CheckCommand(const CheckArguments& arguments);

}  // namespace facet
