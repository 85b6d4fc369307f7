// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/calibration_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <system_error>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/io/basalt_calibration.h"
#include "facet/io/calibration_yaml.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

constexpr double kMinBaselineM = 1e-3;
constexpr double kMaxBaselineM = 10;
constexpr double kMaxTimeOffsetS = 1;
constexpr double kMaxTimeOffsetDifferenceS = 1e-3;

/// As a file, or as something else that whoever reads it complains about.
bool IsThere(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

/// Files in `folder` whose name begins with `prefix` and ends in .yaml or .yml, sorted.
std::vector<fs::path> YamlFilesNamed(const fs::path& folder, const std::string& prefix) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const fs::path extension = entry.path().extension();
    const bool is_yaml = extension == ".yaml" || extension == ".yml";
    if (is_yaml && entry.path().filename().string().starts_with(prefix)) found.push_back(entry);
  }
  std::sort(found.begin(), found.end());
  return found;
}

Duration ReadTimeOffset(const YamlFile& yaml, const YAML::Node& camera) {
  if (!YamlFile::Has(camera, "timeshift_cam_imu")) return {};
  const double offset_s = yaml.RequireNumber(camera, "timeshift_cam_imu");
  if (std::abs(offset_s) > kMaxTimeOffsetS) {
    yaml.Fail(camera["timeshift_cam_imu"], "a time offset above 1 s; the unit must be seconds");
  }
  return FromSeconds(offset_s);
}

/// The transform from the camera before is not used where that from the IMU is given, too; empty if
/// they say the same, otherwise a warning.
std::string ContradictionWithCameraBefore(const YamlFile& yaml,
                                          const YAML::Node& camera,
                                          const SE3& T_BC,
                                          const SE3& T_BC_before) {
  constexpr double kMaxAngle = 0.002, kMaxDistance_m = 0.001;
  const SE3 T_chain = ReadRigid(yaml, camera, "T_cn_cnm1");
  const SE3 difference = T_chain * (T_BC.Inverse() * T_BC_before).Inverse();
  const double angle = LogSO3(difference.q).norm(), distance_m = difference.p.norm();
  if (angle < kMaxAngle && distance_m < kMaxDistance_m) return "";
  char text[300];
  std::snprintf(text,
                sizeof(text),
                ": 'T_cn_cnm1' contradicts the cameras' transforms to the IMU by %.2f deg and "
                "%.1f mm and is not used; if it is the newer one, delete T_cam_imu (or T_imu_cam) "
                "of this camera",
                angle / kDegree,
                1e3 * distance_m);
  return yaml.Where(camera["T_cn_cnm1"]) + text;
}

/// T_BC of one camera of a camchain; `T_BC_before` is that of the camera before it, if there is
/// one.
SE3 ReadKalibrExtrinsics(const YamlFile& yaml,
                         const YAML::Node& camera,
                         const std::optional<SE3>& T_BC_before,
                         std::vector<std::string>& warnings) {
  std::optional<SE3> T_BC;
  if (YamlFile::Has(camera, "T_cam_imu")) {
    T_BC = ReadRigid(yaml, camera, "T_cam_imu").Inverse();
  } else if (YamlFile::Has(camera, "T_imu_cam")) {
    T_BC = ReadRigid(yaml, camera, "T_imu_cam");
  }
  if (T_BC && T_BC_before && YamlFile::Has(camera, "T_cn_cnm1")) {
    const std::string warning = ContradictionWithCameraBefore(yaml, camera, *T_BC, *T_BC_before);
    if (!warning.empty()) warnings.push_back(warning);
  }
  if (T_BC) return *T_BC;
  if (T_BC_before && YamlFile::Has(camera, "T_cn_cnm1")) {
    return *T_BC_before * ReadRigid(yaml, camera, "T_cn_cnm1").Inverse();
  }
  yaml.Fail(camera,
            "'T_cam_imu' is missing: this is a calibration of the cameras alone; use the camchain "
            "that kalibr_calibrate_imu_camera wrote");
}

bool HasImuExtrinsics(const fs::path& camchain) {
  const YamlFile yaml(camchain);
  if (!YamlFile::Has(yaml.root(), "cam0")) return false;
  const YAML::Node cam0 = yaml.root()["cam0"];
  return YamlFile::Has(cam0, "T_cam_imu") || YamlFile::Has(cam0, "T_imu_cam");
}

/// The camchain of the sequence, or an empty path.
fs::path FindCamchain(const std::vector<fs::path>& folders) {
  std::vector<fs::path> all;
  for (const fs::path& folder : folders) {
    for (const fs::path& file : YamlFilesNamed(folder, "camchain"))
      all.push_back(file);
  }
  if (all.size() <= 1) return all.empty() ? fs::path() : all.front();
  std::vector<fs::path> usable;
  std::copy_if(all.begin(), all.end(), std::back_inserter(usable), HasImuExtrinsics);
  if (usable.size() == 1) return usable.front();
  throw InputError(all[1].string() + ": there are several camchain files (also " + all[0].string() +
                   "); choose one with --calibration");
}

fs::path FindImuFile(const std::vector<fs::path>& folders, const fs::path& mav0) {
  for (const fs::path& folder : folders) {
    for (const fs::path& file : YamlFilesNamed(folder, "imu"))
      return file;
  }
  const fs::path euroc = mav0 / "imu0" / "sensor.yaml";
  return IsThere(euroc) ? euroc : fs::path();
}

bool IsBasalt(const fs::path& file) {
  return file.extension() == ".json";
}

}  // namespace

void CheckBaseline(const StereoRig& rig, const std::string& file) {
  const double baseline = rig.baseline_m();
  if (baseline < kMinBaselineM) {
    throw InputError(file + ": both cameras are at the same place (baseline " +
                     std::to_string(baseline) + " m); is the left calibration in both files?");
  }
  if (baseline > kMaxBaselineM) {
    throw InputError(file + ": the cameras are " + std::to_string(baseline) +
                     " m apart; translations must be in metres");
  }
}

std::string TimeOffsetText(Duration offset) {
  char text[80];
  std::snprintf(text, sizeof(text), ", t_imu = t_cam %+.6f s", ToSeconds(offset));
  return text;
}

Calibration ReadEurocCalibration(const fs::path& mav0, const fs::path& imu_file) {
  Calibration result;
  SE3 T_BS_imu;
  const fs::path imu = imu_file.empty() ? mav0 / "imu0" / "sensor.yaml" : imu_file;
  if (imu_file.empty() && !IsThere(imu)) {
    result.warnings.push_back(imu.string() +
                              ": no such file, the IMU is taken for the body, with the noise "
                              "densities of an ADIS16448; give the real ones with "
                              "--imu-calibration");
  } else {
    const YamlFile imu_yaml(imu);
    result.imu_noise = ReadImuNoise(imu_yaml, result.warnings);
    if (YamlFile::Has(imu_yaml.root(), "T_BS"))
      T_BS_imu = ReadRigid(imu_yaml, imu_yaml.root(), "T_BS");
    result.rig.gyro_scale = ReadGyroScale(imu_yaml);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const YamlFile yaml(mav0 / ("cam" + std::to_string(i)) / "sensor.yaml");
    result.rig.cameras[i] = ReadCamera(yaml, yaml.root());
    result.rig.lens_modes[i] = ReadLensModes(yaml, yaml.root());
    result.rig.T_BC[i] = T_BS_imu.Inverse() * ReadRigid(yaml, yaml.root(), "T_BS");
    if (i == 0) result.rig.time_offset = ReadTimeOffset(yaml, yaml.root());
  }
  CheckBaseline(result.rig, (mav0 / "cam1" / "sensor.yaml").string());
  result.source = "EuRoC sensor.yaml in " + mav0.string() + " (T_BS maps camera to body)" +
                  TimeOffsetText(result.rig.time_offset);
  return result;
}

Calibration ReadKalibrCalibration(const fs::path& camchain, const fs::path& imu_file) {
  Calibration result;
  const YamlFile yaml(camchain);
  std::optional<SE3> T_BC_before;
  std::array<Duration, 2> offsets;
  for (std::size_t i = 0; i < 2; ++i) {
    const YAML::Node camera = yaml.Require(yaml.root(), "cam" + std::to_string(i));
    result.rig.cameras[i] = ReadCamera(yaml, camera);
    result.rig.lens_modes[i] = ReadLensModes(yaml, camera);
    result.rig.T_BC[i] = ReadKalibrExtrinsics(yaml, camera, T_BC_before, result.warnings);
    T_BC_before = result.rig.T_BC[i];
    offsets[i] = ReadTimeOffset(yaml, camera);
  }
  CheckBaseline(result.rig, camchain.string());
  result.rig.time_offset = offsets[0];
  result.rig.gyro_scale = ReadGyroScale(yaml);
  result.rig.covariance = ReadCovariance(yaml);
  result.rig.axes_sigma = ReadAxesSigma(yaml);
  if (std::abs(ToSeconds(offsets[1]) - ToSeconds(offsets[0])) > kMaxTimeOffsetDifferenceS) {
    result.warnings.push_back(camchain.string() +
                              ": the cameras have different time offsets; that of cam0 is used");
  }
  if (imu_file.empty()) {
    result.warnings.push_back(camchain.string() +
                              ": no imu.yaml was found, noise densities are those of an ADIS16448; "
                              "give the real ones with --imu-calibration");
  } else {
    result.imu_noise = ReadImuNoise(YamlFile(imu_file), result.warnings);
  }
  const bool is_inverse = YamlFile::Has(yaml.root()["cam0"], "T_cam_imu");
  result.source =
      "Kalibr " + camchain.string() +
      (is_inverse ? " (T_cam_imu maps IMU to camera)" : " (T_imu_cam maps camera to IMU)") +
      TimeOffsetText(result.rig.time_offset);
  if (result.rig.covariance) result.source += ", with the covariance of the run that wrote it";
  if (!imu_file.empty()) result.source += ", IMU noise from " + imu_file.string();
  return result;
}

Calibration FindCalibration(const fs::path& mav0, const CalibrationFiles& files) {
  std::error_code error;
  if (fs::is_directory(files.cameras, error)) {
    const bool has_mav0 = fs::is_directory(files.cameras / "mav0", error);
    return ReadEurocCalibration(has_mav0 ? files.cameras / "mav0" : files.cameras, files.imu);
  }
  const fs::path parent = mav0.parent_path();
  std::vector<fs::path> folders = {mav0, parent, parent / "dso"};
  if (!files.cameras.empty()) folders.insert(folders.begin(), files.cameras.parent_path());
  const fs::path imu = files.imu.empty() ? FindImuFile(folders, mav0) : files.imu;
  if (IsBasalt(files.cameras)) return ReadBasaltCalibration(files.cameras, files.imu);
  if (!files.cameras.empty()) return ReadKalibrCalibration(files.cameras, imu);

  const fs::path camchain = FindCamchain(folders);
  if (!IsThere(mav0 / "cam0" / "sensor.yaml")) {
    if (!camchain.empty()) return ReadKalibrCalibration(camchain, imu);
    throw InputError((mav0 / "cam0" / "sensor.yaml").string() +
                     ": no such file, and no camchain*.yaml beside mav0 either; give a Kalibr "
                     "calibration with --calibration FILE");
  }
  Calibration result = ReadEurocCalibration(mav0, files.imu);
  if (!camchain.empty()) {
    result.warnings.push_back(camchain.string() +
                              ": not read, because there are sensor.yaml files; choose it with "
                              "--calibration");
  }
  return result;
}

std::optional<Calibration> FindCalibrationBeside(const fs::path& folder,
                                                 const CalibrationFiles& files) {
  if (!files.cameras.empty()) return FindCalibration(folder, files);
  const fs::path camchain = FindCamchain({folder});
  if (camchain.empty()) return std::nullopt;
  const fs::path imu = files.imu.empty() ? FindImuFile({folder}, folder) : files.imu;
  return ReadKalibrCalibration(camchain, imu);
}

}  // namespace facet
