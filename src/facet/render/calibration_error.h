// SPDX-License-Identifier: BSD-2-Clause
// What a calibration is off from the cameras that it describes.
#pragma once

#include <cstdint>

#include "facet/base/options.h"
#include "facet/camera/stereo_rig.h"

namespace facet {

/// 1-sigma of each number. The rotations of the cameras make up for the errors of the intrinsics as
/// far as they can, because a calibration finds them together. The defaults leave what
/// studies/calibration_error.py finds in EuRoC's own calibration recording: residuals common to an
/// image region of 0.13 px per axis.
struct CalibrationErrorOptions {
  bool enabled = false;                ///< false: the written calibration is exact
  double focal_px = 0.4;               ///< of each focal length
  double center_px = 0.4;              ///< of each coordinate of the principal point
  double radial = 1e-3;                ///< of the distortion's first two coefficients
  double tangential = 1e-4;            ///< of the other two
  double rotation_deg = 0.02;          ///< of both cameras in the body, about each axis
  double translation_m = 1e-3;         ///< the same, along each axis
  double stereo_rotation_deg = 0.003;  ///< of the right camera in the left one
  double stereo_translation_m = 1e-4;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, "false: the written calibration is exact");
    v.Field("focal_px", focal_px, Range{0, 50}, "1-sigma of each focal length");
    v.Field("center_px", center_px, Range{0, 50}, "1-sigma of the principal point per axis");
    v.Field("radial", radial, Range{0, 0.1}, "1-sigma of two distortion coefficients");
    v.Field("tangential", tangential, Range{0, 0.1}, "1-sigma of the other two");
    v.Field("rotation_deg", rotation_deg, Range{0, 5}, "1-sigma, cameras in the body");
    v.Field("translation_m", translation_m, Range{0, 0.1}, "1-sigma, cameras in the body");
    v.Field("stereo_rotation_deg", stereo_rotation_deg, Range{0, 5}, "1-sigma, between cameras");
    v.Field(
        "stereo_translation_m", stereo_translation_m, Range{0, 0.1}, "1-sigma, between cameras");
  }
};

/// The calibration that somebody measured for this rig; differs with the seed.
StereoRig MeasureRig(const StereoRig& rig,
                     const CalibrationErrorOptions& options,
                     std::uint64_t seed);

}  // namespace facet
