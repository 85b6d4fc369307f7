// SPDX-License-Identifier: BSD-2-Clause
// The ASL/EuRoC layout: mav0/ with cam0/, cam1/ and imu0/, each with its data.csv.
#pragma once

#include <filesystem>

#include "facet/io/stereo_dataset.h"

namespace facet {

/// `sequence` is the folder that holds mav0/, or mav0/ itself. Throws InputError for missing, empty
/// and unusable files, and when there is no calibration.
RecordingFiles ReadAslFolder(const std::filesystem::path& sequence,
                             const CalibrationFiles& calibration = {});

/// Throws InputError as ReadAslFolder and StereoDataset do.
class AslDataset : public StereoDataset {
 public:
  explicit AslDataset(const std::filesystem::path& sequence,
                      const CalibrationFiles& calibration = {})
      : StereoDataset(ReadAslFolder(sequence, calibration)) {}
};

/// The mav0 folder of a sequence, given either. Throws InputError when there is none.
std::filesystem::path FindMav0(const std::filesystem::path& sequence);

/// Ground truth of a sequence: state_groundtruth_estimate0, mocap0 or vicon0; empty path if none.
std::filesystem::path FindTruth(const std::filesystem::path& sequence);

/// The same for programs that cannot do without: throws InputError if there is none.
std::filesystem::path RequireTruth(const std::filesystem::path& sequence);

}  // namespace facet
