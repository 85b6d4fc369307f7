// SPDX-License-Identifier: BSD-2-Clause
// A drive of the KITTI raw data (http://www.cvlibs.net/datasets/kitti/raw_data.php): image_00/,
// image_01/ (grey; or image_02/, image_03/, colour) and oxts/, each with timestamps.txt and data/;
// calib_cam_to_cam.txt, calib_velo_to_cam.txt and calib_imu_to_velo.txt there or one folder above.
#pragma once

#include <filesystem>

#include "facet/io/stereo_dataset.h"

namespace facet {

/// Whether there are oxts/ and two folders with images.
bool IsKittiRaw(const std::filesystem::path& folder);

/// Of the unsynchronised, unrectified variant ("extract"), whose IMU has 100 Hz; the other one has
/// 10 Hz and is refused. Throws InputError for missing, empty and unusable files.
RecordingFiles ReadKittiRaw(const std::filesystem::path& folder,
                            const CalibrationFiles& calibration = {});

}  // namespace facet
