// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/basalt_calibration.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "facet/io/calibration_yaml.h"
#include "facet/io/errors.h"
#include "facet/io/json_file.h"

namespace facet {
namespace {

using Json = nlohmann::ordered_json;

// An entry of the file and where it is, for messages.
class Entry {
 public:
  Entry(const Json& json, std::string where) : json_(json), where_(std::move(where)) {}

  [[noreturn]] void Fail(const std::string& what) const { throw InputError(where_ + ": " + what); }

  bool Has(const std::string& key) const { return json_.is_object() && json_.contains(key); }

  Entry operator[](const std::string& key) const {
    if (!Has(key)) Fail("'" + key + "' is missing");
    return {json_.at(key), where_ + ": " + key};
  }
  Entry operator[](std::size_t i) const {
    if (!json_.is_array() || i >= json_.size())
      Fail("a list of at least " + std::to_string(i + 1) + " is expected");
    return {json_.at(i), where_ + "[" + std::to_string(i) + "]"};
  }

  double Number() const {
    if (!json_.is_number()) Fail("a number is expected");
    const auto value = json_.get<double>();
    if (!std::isfinite(value)) Fail("a finite number is expected");
    return value;
  }
  double Number(const std::string& key) const { return (*this)[key].Number(); }

  std::string Text() const {
    if (!json_.is_string()) Fail("a text is expected");
    return json_.get<std::string>();
  }

 private:
  const Json& json_;
  std::string where_;
};

struct LensType {
  const char* name;
  DistortionModel model;
  std::vector<const char*> coefficients;  // in our order
};

const std::vector<LensType>& LensTypes() {
  static const std::vector<LensType> types = {
      {"pinhole", DistortionModel::kNone, {}},
      {"pinhole-radtan8",
       DistortionModel::kRational,
       {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}},
      {"kb4", DistortionModel::kEquidistant, {"k1", "k2", "k3", "k4"}},
      {"ds", DistortionModel::kDoubleSphere, {"xi", "alpha"}},
      {"eucm", DistortionModel::kExtendedUnified, {"alpha", "beta"}},
      {"ucm", DistortionModel::kExtendedUnified, {"alpha"}},  // with a beta of 1
      {"fov", DistortionModel::kFieldOfView, {"w"}},
  };
  return types;
}

const LensType& FindLensType(const Entry& type) {
  const std::string name = type.Text();
  std::string known;
  for (const LensType& lens : LensTypes()) {
    if (name == lens.name) return lens;
    known += (known.empty() ? "" : ", ") + std::string(lens.name);
  }
  type.Fail("camera type '" + name + "' is not supported (" + known + ")");
}

CameraModel ReadBasaltCamera(const Entry& camera, const Entry& resolution) {
  constexpr double kMaxSide_px = 65536;
  CameraIntrinsics k;
  const double width = resolution[0].Number(), height = resolution[1].Number();
  if (!(width >= 1 && width <= kMaxSide_px && height >= 1 && height <= kMaxSide_px))
    resolution.Fail("a size from 1 to 65536 pixels is expected");
  k.width = static_cast<int>(std::lround(width));
  k.height = static_cast<int>(std::lround(height));
  const LensType& lens = FindLensType(camera["camera_type"]);
  const Entry values = camera["intrinsics"];
  k.fx = values.Number("fx");
  k.fy = values.Number("fy");
  k.cx = values.Number("cx");
  k.cy = values.Number("cy");
  k.distortion = lens.model;
  for (std::size_t i = 0; i < lens.coefficients.size(); ++i)
    k.coefficients[i] = values.Number(lens.coefficients[i]);
  if (lens.model == DistortionModel::kExtendedUnified && lens.coefficients.size() == 1)
    k.coefficients[1] = 1;
  const std::string problem = CameraModel::WhatIsWrong(k);
  if (!problem.empty()) values.Fail("unusable camera: " + problem);
  return CameraModel(k);
}

SE3 ReadPose(const Entry& pose) {
  const Quaterniond q(pose.Number("qw"), pose.Number("qx"), pose.Number("qy"), pose.Number("qz"));
  if (!(std::abs(q.norm() - 1) < 1e-3)) pose.Fail("the quaternion is not of unit length");
  return {q.normalized(), Vector3d(pose.Number("px"), pose.Number("py"), pose.Number("pz"))};
}

// One number for all axes: the largest.
double ReadDensity(const Entry& root, const std::string& key) {
  const Entry list = root[key];
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i)
    largest = std::max(largest, list[i].Number());
  if (!(largest > 0)) list.Fail("a density must be greater than 0");
  return largest;
}

ImuNoise ReadNoise(const Entry& root) {
  ImuNoise noise;
  noise.gyro_noise = ReadDensity(root, "gyro_noise_std");
  noise.accel_noise = ReadDensity(root, "accel_noise_std");
  noise.gyro_walk = ReadDensity(root, "gyro_bias_std");
  noise.accel_walk = ReadDensity(root, "accel_bias_std");
  noise.rate_hz = root.Number("imu_update_rate");
  if (!(noise.rate_hz > 0 && noise.rate_hz <= 1e6))
    root["imu_update_rate"].Fail("a rate in Hz, above 0, is expected");
  return noise;
}

}  // namespace

Calibration ReadBasaltCalibration(const std::filesystem::path& file,
                                  const std::filesystem::path& imu_file) {
  constexpr std::uintmax_t kMaxBytes = 1 << 20;
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    throw InputError(file.string() + ": no such file, or none that can be read");
  if (std::filesystem::file_size(file, error) > kMaxBytes)
    throw InputError(file.string() + ": more than 1 MB is no calibration");
  const Json json = ReadJsonFile(file);
  if (json.is_null()) throw InputError(file.string() + ": cannot be read, or is not JSON");
  const Entry root = Entry(json, file.string())["value0"];
  Calibration result;
  for (std::size_t i = 0; i < 2; ++i) {
    result.rig.cameras[i] = ReadBasaltCamera(root["intrinsics"][i], root["resolution"][i]);
    result.rig.T_BC[i] = ReadPose(root["T_imu_cam"][i]);
  }
  const double offset_s = 1e-9 * root.Number("cam_time_offset_ns");
  if (!(std::abs(offset_s) <= 1)) root["cam_time_offset_ns"].Fail("a time offset above 1 s");
  result.rig.time_offset = FromSeconds(offset_s);
  CheckBaseline(result.rig, file.string());
  result.source = "Basalt " + file.string() + " (T_imu_cam maps camera to IMU)" +
                  TimeOffsetText(result.rig.time_offset);
  if (imu_file.empty()) {
    result.imu_noise = ReadNoise(root);
  } else {
    result.imu_noise = ReadImuNoise(YamlFile(imu_file), result.warnings);
    result.source += ", IMU noise from " + imu_file.string();
  }
  return result;
}

}  // namespace facet
