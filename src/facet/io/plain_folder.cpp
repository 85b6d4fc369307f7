// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/plain_folder.h"

#include <system_error>

#include "facet/io/errors.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

ImageFolder ReadCamera(const fs::path& folder,
                       const char* side,
                       std::vector<std::string>& warnings,
                       StampCounts& left_out) {
  ImageFolder camera;
  camera.folder = folder / side;
  std::error_code error;
  for (const fs::path& list : {camera.folder / "times.csv", folder / "times.csv"}) {
    if (!fs::is_regular_file(list, error)) continue;
    camera.list = list;
    camera.images = ReadImageList(list, warnings, left_out);
    return camera;
  }
  camera.list = camera.folder;
  camera.images = ListImageFolder(camera.folder, warnings);
  return camera;
}

}  // namespace

bool IsPlainFolder(const fs::path& folder) {
  std::error_code error;
  return fs::is_directory(folder / "left", error) && fs::is_directory(folder / "right", error);
}

RecordingFiles ReadPlainFolder(const fs::path& folder, const CalibrationFiles& calibration) {
  const auto found = FindCalibrationBeside(folder, calibration);
  if (!found) {
    throw InputError(folder.string() +
                     ": no camchain*.yaml in it; write Kalibr's calibration there, or give it with "
                     "--calibration FILE");
  }
  RecordingFiles files;
  files.name = fs::weakly_canonical(folder).filename().string();
  files.calibration = *found;
  files.warnings = found->warnings;
  files.cameras[0] = ReadCamera(folder, "left", files.warnings, files.images_left_out);
  files.cameras[1] = ReadCamera(folder, "right", files.warnings, files.images_left_out);
  files.imu_file = folder / "imu.csv";
  files.imu = ReadImuFile(files.imu_file, files.warnings, files.imu_left_out);
  return files;
}

}  // namespace facet
