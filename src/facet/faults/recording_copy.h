// SPDX-License-Identifier: BSD-2-Clause
// A recording that may be changed before it is written again: what faults are planted in.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/calibration/drawn_calibration.h"
#include "facet/camera/stereo_rig.h"
#include "facet/imu/imu_types.h"

namespace facet {

/// Changes pixels in place (CV_8UC1).
using ImageEdit = std::function<void(cv::Mat& image)>;

struct RecordedImage {
  Timestamp t;
  std::filesystem::path file;
  std::vector<ImageEdit> edits;  ///< in this order; empty: the file serves as it is
};

struct RecordingCopy {
  std::filesystem::path source;  ///< folder that holds mav0/, for truth and surfaces
  StereoRig rig;                 ///< as it will be written
  StereoRig exact_rig;           ///< that of the source's truth/, or else the recorded one
  ImuNoise imu_noise;
  std::vector<ImuSample> imu;
  std::optional<ImuErrors> imu_errors;  ///< that the readings have: of truth/, or added since
  std::array<std::vector<RecordedImage>, 2> images;  ///< left, right; in order of time
};

/// What an IMU with these errors, too, would have read; the truth follows.
void AddImuErrors(const ImuErrors& errors, RecordingCopy& recording);

/// Everything but the pixels. Throws InputError.
RecordingCopy ReadRecording(const std::filesystem::path& sequence);

/// In the ASL/EuRoC layout into `folder`, with the source's truth. Images without edits and
/// surfaces are linked, or copied where that is not possible. Throws InputError or OutputError.
void WriteRecording(const RecordingCopy& recording, const std::filesystem::path& folder);

}  // namespace facet
