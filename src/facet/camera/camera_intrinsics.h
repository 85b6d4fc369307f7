// SPDX-License-Identifier: BSD-2-Clause
// The numbers of one camera, as in a calibration file.
#pragma once

#include <array>

namespace facet {

/// How a lens departs from a pinhole; in brackets its coefficients, in the order of
/// CameraIntrinsics.
enum class DistortionModel {
  kNone,
  kRadialTangential,  ///< OpenCV's first four, Kalibr "radtan" [k1 k2 p1 p2]
  kEquidistant,       ///< Kannala-Brandt, OpenCV "fisheye", Kalibr "equidistant" [k1 k2 k3 k4]
  kRational,          ///< OpenCV's five or eight [k1 k2 p1 p2 k3 k4 k5 k6]
  kFieldOfView,       ///< Devernay and Faugeras 2001, Kalibr "fov" [w]
  kDoubleSphere,      ///< Usenko et al. 2018, Kalibr "ds" [xi alpha]
  kExtendedUnified,   ///< Khomutenko et al. 2016, Kalibr "eucm" [alpha beta]
  kUnified            ///< Mei and Rives 2007, Kalibr "omni" with "radtan" [k1 k2 p1 p2 xi]
};

inline constexpr std::size_t kMaxLensCoefficients = 8;

/// How many coefficients a model has.
constexpr std::size_t NumCoefficients(DistortionModel model) {
  switch (model) {
    case DistortionModel::kNone:
      return 0;
    case DistortionModel::kRadialTangential:
    case DistortionModel::kEquidistant:
      return 4;
    case DistortionModel::kRational:
      return 8;
    case DistortionModel::kFieldOfView:
      return 1;
    case DistortionModel::kDoubleSphere:
    case DistortionModel::kExtendedUnified:
      return 2;
    case DistortionModel::kUnified:
      return 5;
  }
  return 0;
}

struct CameraIntrinsics {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;
  DistortionModel distortion = DistortionModel::kNone;
  /// The first NumCoefficients(distortion) are used, the others are zero. The first four of them
  /// are parameters that a run can estimate, the others are as they were calibrated.
  std::array<double, kMaxLensCoefficients> coefficients{};
};

}  // namespace facet
