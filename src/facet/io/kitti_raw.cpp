// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/kitti_raw.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include <Eigen/LU>

#include "facet/io/calibration_yaml.h"
#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"
#include "facet/io/lens_yaml.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

std::string Number(int number, int num_digits) {
  char text[20];
  std::snprintf(text, sizeof(text), "%0*d", num_digits, number);
  return text;
}

/// The numbers of the two cameras: grey ones where there are any.
std::optional<std::array<int, 2>> FindCameras(const fs::path& folder) {
  std::error_code error;
  for (const std::array<int, 2>& pair : {std::array{0, 1}, std::array{2, 3}}) {
    if (std::ranges::all_of(pair, [&](int camera) {
          return fs::is_directory(folder / ("image_" + Number(camera, 2)), error);
        })) {
      return pair;
    }
  }
  return std::nullopt;
}

// ----------------------------------------------------------------------------------------- stamps

/// 2011-09-26 13:02:25.964389445, in nanoseconds since 1970.
std::optional<Timestamp> ParseTime(const std::string& text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, end = 0;
  const int num = std::sscanf(
      text.c_str(), "%4d-%2d-%2d %2d:%2d:%n", &year, &month, &day, &hour, &minute, &end);
  if (num != 5 || end == 0) return std::nullopt;
  const auto date = std::chrono::year(year) / month / day;
  const auto ns =
      ParseScaledDecimal(Trim(std::string_view(text).substr(static_cast<std::size_t>(end))), 9);
  constexpr std::int64_t kMinute = 60000000000;
  constexpr int kFirstYear = 1970, kLastYear = 2261;  // of which all nanoseconds fit into 64 bits
  if (!date.ok() || year < kFirstYear || year > kLastYear || hour < 0 || hour > 23 || minute < 0 ||
      minute > 59 || !ns || *ns < 0 || *ns > kMinute) {
    return std::nullopt;
  }
  const auto days = std::chrono::sys_days(date).time_since_epoch().count();
  return Timestamp{((std::int64_t{days} * 24 + hour) * 60 + minute) * kMinute + *ns};
}

/// Line i belongs to the file with number i.
std::vector<Timestamp> ReadTimes(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream) throw InputError(file.string() + ": no such file");
  std::vector<Timestamp> times;
  for (std::string line; std::getline(stream, line);) {
    if (Trim(line).empty()) continue;
    const auto t = ParseTime(line);
    if (!t) {
      throw InputError(file.string() + ":" + std::to_string(times.size() + 1) +
                       ": a time such as 2011-09-26 13:02:25.964389445 is expected");
    }
    times.push_back(*t);
  }
  if (times.empty()) throw InputError(file.string() + ": holds no data");
  return times;
}

void WarnOfDropped(const fs::path& folder, std::size_t num, std::vector<std::string>& warnings) {
  if (num == 0) return;
  warnings.push_back(folder.string() + ": " + std::to_string(num) +
                     " stamps do not rise or have no file; they were skipped");
}

ImageFolder ReadImages(const fs::path& folder, std::vector<std::string>& warnings) {
  ImageFolder camera;
  camera.list = folder / "timestamps.txt";
  camera.folder = folder / "data";
  const std::vector<Timestamp> times = ReadTimes(camera.list);
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!camera.images.empty() && times[i] <= camera.images.back().t) continue;
    camera.images.push_back({times[i], Number(static_cast<int>(i), 10) + ".png"});
  }
  WarnOfDropped(folder, times.size() - camera.images.size(), warnings);
  return camera;
}

// -------------------------------------------------------------------------------------------- IMU

/// Empty where there is no such file.
std::optional<ImuSample> ReadOxts(const fs::path& file, Timestamp t) {
  constexpr std::size_t kAccel = 11, kGyro = 17, kNumUsed = 20;
  std::ifstream stream(file);
  if (!stream) return std::nullopt;
  std::vector<double> values;
  for (std::string word; values.size() < kNumUsed && stream >> word;) {
    const auto value = ParseDouble(word);
    if (!value || !std::isfinite(*value)) break;
    values.push_back(*value);
  }
  if (values.size() < kNumUsed) {
    throw InputError(file.string() + ": 30 numbers of an OXTS unit are expected, number " +
                     std::to_string(values.size() + 1) + " is none");
  }
  const auto vector = [&](std::size_t i) {
    return Vector3d(values[i], values[i + 1], values[i + 2]);
  };
  return ImuSample{t, vector(kGyro), vector(kAccel)};
}

void RequireFastImu(const fs::path& file, const std::vector<Timestamp>& times) {
  constexpr double kSlowest_s = 0.025;
  if (times.size() < 2) throw InputError(file.string() + ": a single IMU sample");
  const double interval_s =
      ToSeconds(times.back() - times.front()) / static_cast<double>(times.size() - 1);
  if (interval_s < kSlowest_s) return;
  char rate[20];
  std::snprintf(rate, sizeof(rate), "%.1f Hz", 1 / interval_s);
  throw InputError(
      file.string() + ": the IMU has " + rate +
      ", too little to carry a pose from one image to the next: this is the "
      "'synced+rectified' variant; download 'unsynced+unrectified' (the folder ends in "
      "_extract), whose IMU has 100 Hz");
}

std::vector<ImuSample> ReadImu(const fs::path& oxts, std::vector<std::string>& warnings) {
  const std::vector<Timestamp> times = ReadTimes(oxts / "timestamps.txt");
  RequireFastImu(oxts / "timestamps.txt", times);
  std::vector<ImuSample> samples;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!samples.empty() && times[i] <= samples.back().t) continue;
    const fs::path file = oxts / "data" / (Number(static_cast<int>(i), 10) + ".txt");
    if (const auto sample = ReadOxts(file, times[i])) samples.push_back(*sample);
  }
  if (samples.empty()) throw InputError((oxts / "data").string() + ": holds no data");
  WarnOfDropped(oxts, times.size() - samples.size(), warnings);
  return samples;
}

// ------------------------------------------------------------------------------------ calibration

/// A file of lines "name: numbers"; lines with anything else behind the colon are left out.
class KittiCalibrationFile {
 public:
  explicit KittiCalibrationFile(fs::path file) : file_(std::move(file)) {
    std::ifstream stream(file_);
    if (!stream) throw InputError(file_.string() + ": no such file");
    for (std::string line; std::getline(stream, line);) {
      const std::size_t colon = line.find(':');
      if (colon == std::string::npos) continue;
      std::istringstream words(line.substr(colon + 1));
      std::vector<double> numbers;
      bool is_good = true;
      for (std::string word; is_good && words >> word;) {
        const auto number = ParseDouble(word);
        is_good = number && std::isfinite(*number);
        if (is_good) numbers.push_back(*number);
      }
      if (is_good) values_[line.substr(0, colon)] = numbers;
    }
  }

  const std::vector<double>& Require(const std::string& name, std::size_t num) const {
    const auto found = values_.find(name);
    if (found != values_.end() && found->second.size() == num) return found->second;
    throw InputError(file_.string() + ": '" + name + ":' with " + std::to_string(num) +
                     " numbers is expected");
  }

  /// The motion of R and T with this suffix.
  SE3 RequireMotion(const std::string& suffix) const {
    const Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
        Require("R" + suffix, 9).data());
    if (!R.isUnitary(1e-3) || R.determinant() < 0) {
      throw InputError(file_.string() + ": 'R" + suffix + "' is no rotation");
    }
    const std::vector<double>& T = Require("T" + suffix, 3);
    return {Quaterniond(R).normalized(), Vector3d(T[0], T[1], T[2])};
  }

  const fs::path& file() const { return file_; }

 private:
  fs::path file_;
  std::map<std::string, std::vector<double>> values_;
};

CameraModel ReadLens(const KittiCalibrationFile& file, const std::string& camera) {
  const std::vector<double>& S = file.Require("S_" + camera, 2);
  const std::vector<double>& K = file.Require("K_" + camera, 9);
  CameraIntrinsics k;
  k.width = static_cast<int>(std::clamp(S[0], 0.0, 65536.0));
  k.height = static_cast<int>(std::clamp(S[1], 0.0, 65536.0));
  k.fx = K[0];
  k.cx = K[2];
  k.fy = K[4];
  k.cy = K[5];
  SetOpenCvCoefficients(file.Require("D_" + camera, 5), k);
  const std::string wrong = CameraModel::WhatIsWrong(k);
  if (!wrong.empty()) {
    throw InputError(file.file().string() + ": camera " + camera + ": " + wrong +
                     "; give a calibration with --calibration FILE");
  }
  return CameraModel(k);
}

Calibration ReadKittiCalibration(const fs::path& drive,
                                 const std::array<int, 2>& cameras,
                                 const fs::path& imu_file) {
  std::error_code error;
  const bool is_inside = fs::is_regular_file(drive / "calib_cam_to_cam.txt", error);
  const fs::path folder = is_inside ? drive : fs::weakly_canonical(drive).parent_path();
  const KittiCalibrationFile lenses(folder / "calib_cam_to_cam.txt");
  const SE3 T_VB = KittiCalibrationFile(folder / "calib_imu_to_velo.txt").RequireMotion("");
  const SE3 T_C0V = KittiCalibrationFile(folder / "calib_velo_to_cam.txt").RequireMotion("");
  Calibration calibration;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string camera = Number(cameras[i], 2);
    calibration.rig.cameras[i] = ReadLens(lenses, camera);
    const SE3 T_CC0 = lenses.RequireMotion("_" + camera);
    calibration.rig.T_BC[i] = (T_CC0 * T_C0V * T_VB).Inverse();
  }
  calibration.source = "KITTI calib_*.txt in " + folder.string() + ", t_imu = t_cam +0.000000 s";
  if (imu_file.empty()) {
    calibration.warnings.push_back(
        folder.string() +
        ": there are no noise densities of the IMU, those of an ADIS16448 are used; give the real "
        "ones with --imu-calibration");
  } else {
    calibration.imu_noise = ReadImuNoise(YamlFile(imu_file), calibration.warnings);
    calibration.source += ", IMU noise from " + imu_file.string();
  }
  return calibration;
}

}  // namespace

bool IsKittiRaw(const fs::path& folder) {
  std::error_code error;
  return fs::is_directory(folder / "oxts", error) && FindCameras(folder);
}

RecordingFiles ReadKittiRaw(const fs::path& folder, const CalibrationFiles& calibration) {
  const auto cameras = FindCameras(folder);
  if (!cameras) throw InputError(folder.string() + ": no image_00/ and image_01/ in it");
  RecordingFiles files;
  files.name = fs::weakly_canonical(folder).filename().string();
  files.imu_file = folder / "oxts" / "timestamps.txt";
  files.imu = ReadImu(folder / "oxts", files.warnings);
  files.calibration = calibration.cameras.empty()
                          ? ReadKittiCalibration(folder, *cameras, calibration.imu)
                          : FindCalibration(folder, calibration);
  files.warnings.insert(
      files.warnings.begin(), files.calibration.warnings.begin(), files.calibration.warnings.end());
  for (std::size_t i = 0; i < 2; ++i) {
    files.cameras[i] = ReadImages(folder / ("image_" + Number((*cameras)[i], 2)), files.warnings);
  }
  return files;
}

}  // namespace facet
