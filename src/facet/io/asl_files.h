// SPDX-License-Identifier: BSD-2-Clause
// The csv files of an ASL/EuRoC sequence, and folders that do without. Bad lines in an otherwise
// good file (unreadable, not finite, duplicate or backward stamps) are skipped, counted and
// reported, as are single stamps that are far away from the ones around them
// (stray_stamps.h); a file full of them is an error.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "facet/imu/imu_types.h"
#include "facet/io/stamp_counts.h"

namespace facet {

struct ImageListEntry {
  Timestamp t;
  std::string file;  ///< name relative to the `data` folder
};

/// cam?/data.csv: stamp, file name (`<stamp>.png` where there is none). Stamps strictly increasing.
///
/// This and ReadImuFile append to `warnings`, add to `left_out` and throw InputError with file and
/// line for a missing or empty file, stamps that are not nanoseconds, and more than a tenth of
/// unusable lines.
std::vector<ImageListEntry> ReadImageList(const std::filesystem::path& csv,
                                          std::vector<std::string>& warnings,
                                          StampCounts& left_out);

/// The PNG, JPEG, WebP and PGM files of a folder that are named by their stamps, in the order of
/// these. Files with other names are left out, counted and appended to `warnings`. Throws
/// InputError when no file is left, and for stamps that are not nanoseconds.
std::vector<ImageListEntry> ListImageFolder(const std::filesystem::path& folder,
                                            std::vector<std::string>& warnings);

/// imu0/data.csv: stamp, gyroscope [rad/s], accelerometer [m/s^2]. Stamps strictly increasing, all
/// numbers finite.
std::vector<ImuSample> ReadImuFile(const std::filesystem::path& csv,
                                   std::vector<std::string>& warnings,
                                   StampCounts& left_out);

}  // namespace facet
