// SPDX-License-Identifier: BSD-2-Clause
// The frames of a finished run, as result_writer.h left them.
#pragma once

#include <filesystem>
#include <vector>

#include "facet/io/result_writer.h"

namespace facet {

/// From states.csv and timing.csv of a result folder; without states.csv the poses of
/// trajectory.tum. What the files do not say is nan or empty. Sorted as the file is. Throws
/// InputError naming the file and the line where ReadStates does or a stamp is no number, and where
/// neither file is there.
std::vector<FrameRecord> ReadFrameRecords(const std::filesystem::path& folder);

}  // namespace facet
