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

std::optional<ImuErrors> UnknownImuErrors(const CalibrationDraw& draw) {
  if (!draw.seed || !draw.parts.scale) return std::nullopt;
  return DrawImuErrors(*draw.seed, draw.options);
}

Vector3d GyroScaleWith(const ImuErrors& errors, const Vector3d& before) {
  const Vector3d ones = Vector3d::Ones();
  return (before + ones).cwiseProduct(errors.of_gyro.diagonal()) - ones;
}

void AddImuErrors(const ImuErrors& errors, std::vector<ImuSample>& samples) {
  for (ImuSample& sample : samples) {
    sample.gyro = errors.of_gyro * sample.gyro;
    sample.accel = errors.of_accel * sample.accel;
  }
}

}  // namespace facet
