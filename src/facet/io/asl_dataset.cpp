// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/asl_dataset.h"

#include <system_error>

#include "facet/io/errors.h"

namespace facet {

namespace fs = std::filesystem;

fs::path FindMav0(const fs::path& sequence) {
  std::error_code error;
  if (!fs::is_directory(sequence, error)) {
    throw InputError(sequence.string() + ": no such folder");
  }
  // A trailing slash would make an empty file name, "." would have no parent.
  fs::path folder = fs::weakly_canonical(sequence, error);
  if (error) folder = sequence;
  if (fs::is_directory(folder / "mav0", error)) return folder / "mav0";
  if (fs::is_directory(folder / "cam0", error)) return folder;
  throw InputError(
      sequence.string() +
      ": holds neither mav0/ nor cam0/; a sequence in the ASL/EuRoC layout is expected");
}

fs::path FindTruth(const fs::path& sequence) {
  const fs::path mav0 = FindMav0(sequence);
  std::error_code error;
  for (const char* name : {"state_groundtruth_estimate0", "mocap0", "vicon0"}) {
    const fs::path file = mav0 / name / "data.csv";
    if (fs::is_regular_file(file, error)) return file;
  }
  return {};
}

fs::path RequireTruth(const fs::path& sequence) {
  const fs::path file = FindTruth(sequence);
  if (file.empty()) {
    throw InputError(sequence.string() +
                     ": no ground truth; state_groundtruth_estimate0/data.csv, mocap0/data.csv or "
                     "vicon0/data.csv is expected in mav0/");
  }
  return file;
}

RecordingFiles ReadAslFolder(const fs::path& sequence, const CalibrationFiles& calibration) {
  const fs::path mav0 = FindMav0(sequence);
  RecordingFiles files;
  files.name = (mav0.filename() == "mav0" ? mav0.parent_path() : mav0).filename().string();
  files.calibration = FindCalibration(mav0, calibration);
  files.warnings = files.calibration.warnings;
  for (std::size_t i = 0; i < 2; ++i) {
    const fs::path camera = mav0 / ("cam" + std::to_string(i));
    files.cameras[i] = {camera / "data.csv", camera / "data", {}};
    files.cameras[i].images =
        ReadImageList(files.cameras[i].list, files.warnings, files.images_left_out);
  }
  files.imu_file = mav0 / "imu0" / "data.csv";
  files.imu = ReadImuFile(files.imu_file, files.warnings, files.imu_left_out);
  return files;
}

}  // namespace facet
