// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/calibration_writer.h"

#include <cstdio>
#include <initializer_list>

#include "facet/calibration/calibration_vector.h"
#include "facet/io/lens_yaml.h"
#include "facet/io/text_file.h"

namespace facet {
namespace {

std::string Number(double value) {
  char text[40];
  std::snprintf(text, sizeof(text), "%.12g", value);
  return text;
}

template <class Values>
std::string List(const Values& values) {
  std::string text;
  for (const double value : values)
    text += (text.empty() ? "[" : ", ") + Number(value);
  return (text.empty() ? "[" : text) + "]";
}

std::string Rigid(const std::string& key, const SE3& T) {
  const Matrix3d R = T.R();
  std::string text = "  " + key + ":\n";
  for (int i = 0; i < 3; ++i)
    text += "  - " + List(std::initializer_list<double>{R(i, 0), R(i, 1), R(i, 2), T.p(i)}) + "\n";
  return text + "  - [0.0, 0.0, 0.0, 1.0]\n";
}

std::string Camera(const StereoRig& rig, std::size_t c) {
  const CameraIntrinsics& k = rig.cameras[c].intrinsics();
  const LensInFile lens = LensForFile(k);
  std::string text = "cam" + std::to_string(c) + ":\n";
  text += Rigid("T_cam_imu", rig.T_BC[c].Inverse());
  if (c == 1) text += Rigid("T_cn_cnm1", rig.T_C1C0());
  text += std::string("  cam_overlaps: [") + (c == 0 ? "1" : "0") + "]\n";
  text += "  camera_model: " + lens.camera_model + "\n";
  text += "  distortion_coeffs: " + List(lens.coefficients) + "\n";
  text += "  distortion_model: " + lens.distortion_model + "\n";
  text += "  intrinsics: " + List(lens.intrinsics) + "\n";
  if (!rig.lens_modes[c].isZero(0)) {
    text += "  # What the lens does beside its model [px]: the amounts of ten smooth fields.\n";
    text += "  lens_modes: " + List(rig.lens_modes[c]) + "\n";
  }
  text += "  resolution: [" + std::to_string(k.width) + ", " + std::to_string(k.height) + "]\n";
  text += "  timeshift_cam_imu: " + Number(ToSeconds(rig.time_offset)) + "\n";
  return text;
}

std::string Covariance(const MatrixXd& covariance) {
  std::string text =
      "# Of the deviations of the parameters; rotations in rad, about the axes of the left camera\n"
      "# (stereo) and of the IMU (mount); translations in m, time in s;\n"
      "# modes of the lenses in px; scales are shares.\n"
      "covariance:\n  parameters: [";
  for (const char* name : kCalibrationNames)
    text += (name == kCalibrationNames.front() ? "" : ", ") + std::string(name);
  text += "]\n  matrix:\n";
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    const Eigen::RowVectorXd row = covariance.row(i);
    text += "  - " + List(row) + "\n";
  }
  return text;
}

}  // namespace

std::string CalibrationYaml(const StereoRig& rig) {
  std::string text = Camera(rig, 0) + Camera(rig, 1);
  if (!rig.gyro_scale.isZero(0))
    text += "# By what share the gyroscope reads too much on each axis.\ngyro_scale: " +
            List(rig.gyro_scale) + "\n";
  if (rig.covariance) text += Covariance(*rig.covariance);
  if (rig.axes_sigma > 0) {
    text +=
        "# The mount is that against the axes of the gyroscope, which may be off those of the body "
        "by\n"
        "# this much about each axis, 1-sigma [rad]; not part of the covariance.\n"
        "axes_sigma: " +
        Number(rig.axes_sigma) + "\n";
  }
  return text;
}

void WriteCalibration(const std::filesystem::path& file, const StereoRig& rig) {
  WriteTextFile(file, CalibrationYaml(rig));
}

}  // namespace facet
