// SPDX-License-Identifier: BSD-2-Clause
// Every knob of the simulator that `facet simulate --set` reaches.
#pragma once

#include "facet/calibration/drawn_calibration.h"
#include "facet/render/image_sensor.h"
#include "facet/sim/imu_sensor.h"

namespace facet {

/// How images are taken.
struct ImageOptions {
  double rate_hz = 20;
  /// Rays per pixel; more are taken where the image moves by more pixels than this during the
  /// exposure. Raising it costs time.
  int rays_per_pixel = 4;
  int max_rays_per_pixel = 16;
  /// 1-sigma of the lens' point spread [px].
  double blur_px = 0.5;
  bool motion_blur = true;
  double max_exposure_s = 0.008;  ///< in the dark; shorter where it is bright
  bool auto_exposure = true;      ///< follows the brightness, with a drift
  double mean_level = 105;        ///< grey level that the exposure aims at
  double right_gain = 0.1;        ///< right camera brighter or darker by up to this share
  bool highlights = true;         ///< lamps that mirror in glossy surfaces
  double lens_misfit_px = 0.13;   ///< root mean square per axis, with --lens-misfit

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("rate_hz", rate_hz, Range{1, 200}, "stereo pairs per second");
    v.Field("rays_per_pixel", rays_per_pixel, Range{1, 64}, "more are smoother and slower");
    v.Field("max_rays_per_pixel", max_rays_per_pixel, Range{1, 64}, "limit in fast motion");
    v.Field("blur_px", blur_px, Range{0, 5}, "point spread of the lens, 1-sigma");
    v.Field("motion_blur", motion_blur, "motion during the exposure");
    v.Field("max_exposure_s", max_exposure_s, Range{1e-5, 0.05}, "exposure time in the dark");
    v.Field("auto_exposure", auto_exposure, "false: one gain for all images");
    v.Field("mean_level", mean_level, Range{10, 250}, "grey level that the exposure aims at");
    v.Field(
        "right_gain", right_gain, Range{0, 0.5}, "largest brightness difference of the cameras");
    v.Field("highlights", highlights, "lamps that mirror in glossy surfaces");
    v.Field("lens_misfit_px", lens_misfit_px, Range{0, 5}, "rms of what --lens-misfit adds");
  }
};

/// What is written besides images and IMU.
struct TruthOptions {
  double points_per_m2 = 5000;
  int max_points = 2'000'000;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("points_per_m2", points_per_m2, Range{1, 1e6}, "surface points that were seen");
    v.Field("max_points", max_points, Range{1, 1e8}, "upper limit of all of them");
  }
};

struct SimulatorOptions {
  ImageOptions image;
  ImageSensorOptions sensor;
  ImuSensorOptions imu;
  DrawnCalibrationOptions calibration;  ///< sizes of --draw-calibration
  TruthOptions truth;
  double min_clearance_m = 0.3;  ///< between the body's path and every surface
  /// Distance at which `room` has benches, heaps and rails in front of the cameras [m], as for
  /// somebody who holds them and looks at something. 0: none; -1: as the made-up motion says.
  double near_things_m = -1;
  /// How far made-up motions look down, besides what they do by themselves [deg].
  double look_down_deg = 0;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Group("image", image);
    v.Group("sensor", sensor);
    v.Group("imu", imu);
    v.Group("calibration", calibration);
    v.Group("truth", truth);
    v.Field("min_clearance_m", min_clearance_m, Range{0, 10}, "between path and surfaces");
    v.Field("near_things_m",
            near_things_m,
            Range{-1, 3},
            "room: things about this far before the cameras; 0: none, -1: 0.5 if hand-held");
    v.Field("look_down_deg",
            look_down_deg,
            Range{-90, 90},
            "made-up motions look down by so much more");
  }
};

}  // namespace facet
