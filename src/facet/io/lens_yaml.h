// SPDX-License-Identifier: BSD-2-Clause
// Lenses as calibration files write them: Kalibr's camera models and distortion models, and
// EuRoC's and OpenCV's names for the same.
#pragma once

#include <string>
#include <vector>

#include "facet/camera/camera_model.h"
#include "facet/io/yaml_file.h"

namespace facet {

/// The four entries of a camera in a camchain.
struct LensInFile {
  std::string camera_model;      ///< pinhole, omni, ds, eucm
  std::string distortion_model;  ///< radtan, equidistant, fov, none
  std::vector<double> intrinsics;
  std::vector<double> coefficients;
};

/// As Kalibr writes it. OpenCV's model with eight coefficients, which Kalibr does not have, is
/// "radtan" with eight.
LensInFile LensForFile(const CameraIntrinsics& intrinsics);

/// camera_model, intrinsics and distortion of a camera, over the size in `size_only`. Throws
/// InputError with file and line for models that are not known, the wrong number of values, and
/// what no camera has.
CameraModel ReadLens(const YamlFile& yaml, const YAML::Node& camera, CameraIntrinsics size_only);

/// OpenCV's list of coefficients (4, 5, 8, 12 or 14), of which a thin prism and a tilted sensor
/// (those from the ninth on) must be zero; false if it is none of these. With k3 and k4 to k6 zero
/// the model is kRadialTangential.
bool SetOpenCvCoefficients(const std::vector<double>& coefficients, CameraIntrinsics& intrinsics);

}  // namespace facet
