// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

namespace facet {

/// What `facet convert` is told on the command line.
struct ConvertArguments {
  std::string recording, out, calibration, imu_calibration;
  std::vector<std::string> topics;   // role=name
  std::string compression = "zstd";  // of an MCAP file: zstd or none
  bool quiet = false;
};

/// `facet convert`: writes a recording as a folder in the ASL layout (asl_writer.h), in which an
/// interrupted conversion goes on, or, where OUT ends in .mcap, as such a file
/// (mcap_recording_writer.h). Throws InputError, OutputError, and ConfigError where OUT is
/// something else.
void ConvertCommand(const ConvertArguments& arguments);

}  // namespace facet
