// SPDX-License-Identifier: BSD-2-Clause
// The plain layout, for recordings of no other kind: left/ and right/ with images, imu.csv, and
// Kalibr's calibration (docs/recordings.md, "A plain folder").
#pragma once

#include <filesystem>

#include "facet/io/stereo_dataset.h"

namespace facet {

/// Whether there are left/ and right/.
bool IsPlainFolder(const std::filesystem::path& folder);

/// Stamps of images are those of times.csv in the folder of the camera (stamp, file), or else of
/// times.csv beside both folders, or else the names of the files. Throws InputError for missing,
/// empty and unusable files, and when there is no calibration.
RecordingFiles ReadPlainFolder(const std::filesystem::path& folder,
                               const CalibrationFiles& calibration = {});

}  // namespace facet
