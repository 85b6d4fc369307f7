// SPDX-License-Identifier: BSD-2-Clause
#include <string>

#include "april_corners_study.h"

#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"

namespace facet {

namespace {

constexpr int kCornersPerTag = 4;

double Number(const CsvReader& csv, std::size_t field) {
  const auto value = ParseDouble(csv.fields().at(field));
  if (!value) throw InputError(csv.Where() + ": not a number");
  return *value;
}

std::int64_t Integer(const CsvReader& csv, std::size_t field) {
  const auto value = ParseInteger(csv.fields().at(field));
  if (!value) throw InputError(csv.Where() + ": not an integer");
  return *value;
}

bool NextRow(CsvReader& csv, std::size_t num_fields) {
  if (!csv.Next()) return false;
  if (csv.fields().size() < num_fields) throw InputError(csv.Where() + ": too few columns");
  return true;
}

int CornerOf(const CsvReader& csv, std::size_t tag_field) {
  return static_cast<int>(kCornersPerTag * Integer(csv, tag_field) + Integer(csv, tag_field + 1));
}

void ReadCorners(const std::filesystem::path& file,
                 std::optional<Vector2d> CornerObservation::*pixel,
                 AprilRecording& recording) {
  CsvReader csv(file);
  while (NextRow(csv, 5)) {
    auto& frame = recording.frames[Timestamp{Integer(csv, 0)}];
    frame[CornerOf(csv, 1)].*pixel = Vector2d(Number(csv, 3), Number(csv, 4));
  }
}

void ReadImu(const std::filesystem::path& file, ImuBuffer& imu) {
  CsvReader csv(file);
  while (NextRow(csv, 7)) {
    imu.Add({Timestamp{Integer(csv, 0)},
             {Number(csv, 1), Number(csv, 2), Number(csv, 3)},
             {Number(csv, 4), Number(csv, 5), Number(csv, 6)}});
  }
}

void ReadBoard(const std::filesystem::path& file, AprilRecording& recording) {
  CsvReader csv(file);
  while (NextRow(csv, 5)) {
    recording.corners_G[CornerOf(csv, 0)] = {Number(csv, 2), Number(csv, 3), Number(csv, 4)};
  }
}

}  // namespace

AprilRecording LoadAprilRecording(const std::filesystem::path& folder,
                                  const std::filesystem::path& mav0) {
  AprilRecording recording;
  recording.calibration = FindCalibration(mav0, {});
  ReadCorners(folder / "cam0_corners.csv", &CornerObservation::px_left, recording);
  ReadCorners(folder / "cam1_corners.csv", &CornerObservation::px_right, recording);
  ReadImu(folder / "imu0.csv", recording.imu);
  ReadBoard(folder / "board.csv", recording);
  recording.truth = ReadTrajectory(folder / "pnp_pose_of_body_in_board.tum").poses;
  if (recording.imu.empty()) throw InputError(folder.string() + ": no IMU samples");
  return recording;
}

}  // namespace facet
