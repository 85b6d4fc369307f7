// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/calibration_draw.h"

#include "facet/io/errors.h"

namespace facet {

StereoRig WrittenCalibration(const StereoRig& exact, const CalibrationDraw& draw) {
  if (!draw.seed) return exact;
  const auto drawn = DrawCalibration(exact, *draw.seed, draw.parts, draw.options);
  if (drawn) return *drawn;
  throw ConfigError(
      "--draw-calibration " + std::to_string(*draw.seed) +
      ": a board 0.6 to 1.3 m away does not calibrate these cameras; do both see the same things?");
}

}  // namespace facet
