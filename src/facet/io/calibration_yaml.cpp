// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/calibration_yaml.h"

#include <cmath>
#include <cstdio>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "facet/calibration/calibration_vector.h"
#include "facet/io/errors.h"
#include "facet/io/lens_yaml.h"

namespace facet {
namespace {

constexpr double kMaxRotationError = 1e-3;
constexpr double kMaxLeverArmM = 10;
constexpr double kMaxAxesSigma = 0.2;  // rad
constexpr double kMaxLensMode_px = 20;
constexpr double kMaxSide_px = 65536;
// Densities that far from those of a usual sensor are no units' mistake.
constexpr double kMostTimesUsual = 1e7;
constexpr double kMaxRate_hz = 1e6;

Eigen::Matrix<double, 3, 4> ReadMatrix(const YamlFile& yaml, const YAML::Node& node) {
  const YAML::Node data = YamlFile::Has(node, "data") ? node["data"] : node;
  const std::vector<double> v = yaml.Numbers(data);
  if (v.size() != 12 && v.size() != 16) {
    yaml.Fail(data, "a 4x4 matrix has 16 numbers, here are " + std::to_string(v.size()));
  }
  if (v.size() == 16 && (v[12] != 0 || v[13] != 0 || v[14] != 0 || v[15] != 1)) {
    yaml.Fail(data,
              "the last row of a rigid transform must be 0 0 0 1 (is the matrix transposed?)");
  }
  return Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(v.data());
}

/// `expected`: that of a usual MEMS IMU, which takes the place of one that is missing.
double ReadDensity(const YamlFile& yaml,
                   const YAML::Node& node,
                   const std::string& key,
                   double expected,
                   std::vector<std::string>& warnings) {
  if (!YamlFile::Has(node, key)) {
    char value[40];
    std::snprintf(value, sizeof(value), "%.5g", expected);
    warnings.push_back(yaml.file().string() + ": '" + key + "' is missing, that of an ADIS16448 (" +
                       value + ") is used");
    return expected;
  }
  const double value = yaml.RequireNumber(node, key);
  if (value <= 0) yaml.Fail(node[key], "'" + key + "' must be greater than 0");
  if (value > kMostTimesUsual * expected || value < expected / kMostTimesUsual)
    yaml.Fail(node[key], "'" + key + "' is " + node[key].Scalar() + ", and no IMU's");
  if (value > 300 * expected || value < expected / 300) {
    warnings.push_back(yaml.Where(node[key]) + ": '" + key + "' is " +
                       std::to_string(value / expected) +
                       " times that of a usual MEMS IMU; is it the continuous-time density?");
  }
  return value;
}

bool IsLensMode(Eigen::Index column) {
  return column >= kLensModes && column < kNumLensColumns;
}

/// Where parameters with these names are in CalibrationVector: all, or all but the modes of the
/// lenses. Empty if they are others.
std::optional<std::vector<Eigen::Index>> ColumnsOf(const YAML::Node& names) {
  constexpr std::size_t kWithoutModes = kNumCalibration - 2 * kNumLensModes;
  if (!names.IsSequence()) return std::nullopt;
  const bool has_modes = names.size() == kNumCalibration;
  if (!has_modes && names.size() != kWithoutModes) return std::nullopt;
  std::vector<Eigen::Index> columns;
  for (Eigen::Index i = 0; i < kNumCalibration; ++i) {
    if (!has_modes && IsLensMode(i)) continue;
    const YAML::Node name = names[columns.size()];
    if (!name.IsScalar() || name.Scalar() != kCalibrationNames[static_cast<std::size_t>(i)])
      return std::nullopt;
    columns.push_back(i);
  }
  return columns;
}

}  // namespace

SE3 ReadRigid(const YamlFile& yaml, const YAML::Node& parent, const std::string& key) {
  const YAML::Node node = yaml.Require(parent, key);
  const Eigen::Matrix<double, 3, 4> M = ReadMatrix(yaml, node);
  const Matrix3d R = M.leftCols<3>();
  const Vector3d p = M.col(3);
  const double error = (R.transpose() * R - Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error < kMaxRotationError)) {
    yaml.Fail(node,
              "'" + key + "' is singular or not a rotation (columns are off orthonormal by " +
                  std::to_string(error) + ")");
  }
  if (R.determinant() < 0) yaml.Fail(node, "'" + key + "' is a reflection, not a rotation");
  if (p.norm() > kMaxLeverArmM) {
    yaml.Fail(node,
              "'" + key + "' moves by " + std::to_string(p.norm()) + " m; the unit must be metres");
  }
  return {Quaterniond(R).normalized(), p};
}

CameraModel ReadCamera(const YamlFile& yaml, const YAML::Node& camera) {
  CameraIntrinsics k;
  yaml.Require(camera, "camera_model");
  const YAML::Node resolution = yaml.Require(camera, "resolution");
  const std::vector<double> size = yaml.Numbers(resolution);
  if (size.size() != 2) yaml.Fail(resolution, "'resolution' must be [width, height]");
  for (const double side : size) {
    if (!(side >= 1 && side <= kMaxSide_px))
      yaml.Fail(resolution, "unusable camera: 'resolution' must be from 1 to 65536 pixels");
  }
  k.width = static_cast<int>(std::lround(size[0]));
  k.height = static_cast<int>(std::lround(size[1]));
  return ReadLens(yaml, camera, k);
}

LensModeVector ReadLensModes(const YamlFile& yaml, const YAML::Node& camera) {
  if (!YamlFile::Has(camera, "lens_modes")) return LensModeVector::Zero();
  const YAML::Node node = camera["lens_modes"];
  const std::vector<double> values = yaml.Numbers(node);
  if (values.size() != kNumLensModes) {
    yaml.Fail(node,
              "a lens has " + std::to_string(kNumLensModes) + " modes, here are " +
                  std::to_string(values.size()));
  }
  const LensModeVector modes = Eigen::Map<const LensModeVector>(values.data());
  if (!(modes.cwiseAbs().maxCoeff() <= kMaxLensMode_px))
    yaml.Fail(node, "a mode of a lens is what it does beside its model, in pixels, such as 0.05");
  return modes;
}

Vector3d ReadGyroScale(const YamlFile& yaml) {
  if (!YamlFile::Has(yaml.root(), "gyro_scale")) return Vector3d::Zero();
  const YAML::Node node = yaml.root()["gyro_scale"];
  const std::vector<double> values = yaml.Numbers(node);
  if (values.size() != 3) yaml.Fail(node, "a scale has three numbers, one for each axis");
  const Vector3d scale = Eigen::Map<const Vector3d>(values.data());
  if (!(scale.cwiseAbs().maxCoeff() < kMaxGyroScale)) {
    yaml.Fail(node, "a scale is the share by which an axis reads too much, such as 0.003");
  }
  return scale;
}

std::shared_ptr<const MatrixXd> ReadCovariance(const YamlFile& yaml) {
  if (!YamlFile::Has(yaml.root(), "covariance")) return nullptr;
  const YAML::Node node = yaml.root()["covariance"];
  const YAML::Node names = yaml.Require(node, "parameters");
  const std::optional<std::vector<Eigen::Index>> columns = ColumnsOf(names);
  if (!columns) {
    yaml.Fail(names,
              std::string("the parameters must be those that 'facet run' writes: ") +
                  kCalibrationNames.front() + " ... " + kCalibrationNames.back());
  }
  const YAML::Node rows = yaml.Require(node, "matrix");
  const std::vector<double> values = yaml.Numbers(rows);
  const std::size_t size = columns->size();
  if (values.size() != size * size) {
    yaml.Fail(rows,
              "a matrix of " + std::to_string(size) + " x " + std::to_string(size) + " has " +
                  std::to_string(size * size) + " numbers, here are " +
                  std::to_string(values.size()));
  }
  CalibrationMatrix matrix = CalibrationMatrix::Identity();
  matrix(*columns, *columns) =
      Eigen::Map<const MatrixXd>(values.data(), std::ssize(*columns), std::ssize(*columns));
  const std::string problem = WhatIsWrong(matrix);
  if (!problem.empty()) yaml.Fail(rows, problem);
  matrix = 0.5 * (matrix + matrix.transpose()).eval();
  if (size < kNumCalibration) ForgetLensModes(matrix);
  return std::make_shared<const MatrixXd>(matrix);
}

double ReadAxesSigma(const YamlFile& yaml) {
  if (!YamlFile::Has(yaml.root(), "axes_sigma")) return 0;
  const double sigma = yaml.RequireNumber(yaml.root(), "axes_sigma");
  if (!(sigma >= 0 && sigma < kMaxAxesSigma))
    yaml.Fail(yaml.root()["axes_sigma"],
              "what the axes of an IMU are off by is an angle in radians, such as 0.001");
  return sigma;
}

ImuNoise ReadImuNoise(const YamlFile& yaml, std::vector<std::string>& warnings) {
  const YAML::Node node = YamlFile::Has(yaml.root(), "imu0") ? yaml.root()["imu0"] : yaml.root();
  const ImuNoise usual;
  ImuNoise n;
  n.gyro_noise = ReadDensity(yaml, node, "gyroscope_noise_density", usual.gyro_noise, warnings);
  n.gyro_walk = ReadDensity(yaml, node, "gyroscope_random_walk", usual.gyro_walk, warnings);
  n.accel_noise =
      ReadDensity(yaml, node, "accelerometer_noise_density", usual.accel_noise, warnings);
  n.accel_walk = ReadDensity(yaml, node, "accelerometer_random_walk", usual.accel_walk, warnings);
  for (const char* key : {"rate_hz", "update_rate"}) {
    if (!YamlFile::Has(node, key)) continue;
    n.rate_hz = yaml.RequireNumber(node, key);
    if (!(n.rate_hz > 0 && n.rate_hz <= kMaxRate_hz))
      yaml.Fail(node[key], "'" + std::string(key) + "' must be a rate in Hz, above 0");
  }
  return n;
}

}  // namespace facet
