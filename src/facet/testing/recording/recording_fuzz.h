// SPDX-License-Identifier: BSD-2-Clause
// For fuzzing: bags of every kind. A bag may be read or complained about (errors.h); reading it may
// not crash, hang or fail in any other way.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace facet {

/// Small good recordings: ROS 1 bags and MCAP files with each compression, with and without chunks
/// and index, a database, with raw and compressed images and calibration.
std::vector<std::string> RecordingSeeds();

/// Writes the content to a file in `folder`, opens it as a recording, reads it to its end and
/// decodes its frames. Returns whether that went well; what is neither InputError nor ConfigError
/// is let through.
bool ReadsRecordingOrComplains(const std::filesystem::path& folder, const std::string& content);

}  // namespace facet
