// SPDX-License-Identifier: BSD-2-Clause
// From radiance to the grey levels of a camera.
#pragma once

#include <opencv2/core.hpp>

#include "facet/base/options.h"
#include "facet/base/random.h"
#include "facet/render/camera_rays.h"

namespace facet {

/// The defaults are measured on the EuRoC vehicle's cameras: variance 0.25 + 0.0135 per grey level.
struct ImageSensorOptions {
  bool add_noise = true;
  double read_noise = 0.4;     ///< 1-sigma of each pixel, in grey levels
  double shot_noise = 0.0135;  ///< variance per grey level
  double vignetting = 0.6;     ///< share of the law (CameraRays::Vignette); 0 none
  double black_level = 1;      ///< grey level without light

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("add_noise", add_noise, "shot and read noise");
    v.Field("read_noise", read_noise, Range{0, 50}, "1-sigma of a dark pixel, grey levels");
    v.Field("shot_noise", shot_noise, Range{0, 5}, "variance per grey level");
    v.Field(
        "vignetting", vignetting, Range{0, 1}, "share of the cos^4 law (fisheyes: cos sin(x)/x)");
    v.Field("black_level", black_level, Range{0, 50}, "grey level without light");
  }
};

/// 8-bit image of `radiance` times `gain` (grey levels per radiance), with vignetting and noise.
cv::Mat1b ExposeSensor(const cv::Mat1f& radiance,
                       const CameraRays& camera,
                       double gain,
                       const ImageSensorOptions& options,
                       Rng rng);

}  // namespace facet
