// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/calibration_error.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "facet/base/check.h"

namespace facet {

namespace {

// Where the right camera sees what is at infinity behind a left pixel.
std::optional<Vector2d> RightPixel(const StereoRig& rig, const Vector2d& px) {
  const std::optional<Vector3d> ray = rig.cameras[0].Unproject(px);
  if (!ray) return std::nullopt;
  return rig.cameras[1].Project(rig.T_C1C0().q * *ray);
}

void CompareDisparities(const StereoRig& estimate, const StereoRig& truth, CalibrationError& out) {
  constexpr int kPlaces = 24;  // along each side of the image
  const CameraModel& left = truth.cameras[0];
  Vector2d sum = Vector2d::Zero(), squares = Vector2d::Zero();
  int num = 0;
  for (int i = 0; i < kPlaces; ++i) {
    for (int j = 0; j < kPlaces; ++j) {
      const Vector2d px((i + 0.5) * left.width() / kPlaces, (j + 0.5) * left.height() / kPlaces);
      const auto is = RightPixel(truth, px), seems = RightPixel(estimate, px);
      if (!is || !seems || !truth.cameras[1].IsInside(*is, 0)) continue;
      const Vector2d error = *seems - *is;
      sum += error;
      squares += error.cwiseAbs2();
      ++num;
    }
  }
  if (num == 0) return;
  out.disparity_mean_px = sum.x() / num;
  out.disparity_rms_px = std::sqrt(squares.x() / num);
  out.vertical_rms_px = std::sqrt(squares.y() / num);
}

}  // namespace

CalibrationError CompareCalibrations(const StereoRig& estimate, const StereoRig& truth) {
  CalibrationError out;
  out.error = CalibrationDifference(truth, estimate);
  CompareDisparities(estimate, truth, out);
  if (estimate.covariance) {
    FACET_CHECK(estimate.covariance->rows() == kNumCalibration);
    const CalibrationMatrix covariance = *estimate.covariance;
    const CalibrationVector scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
    const CalibrationMatrix correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
    const CalibrationVector z = scale.cwiseProduct(out.error);
    out.nees = z.dot(correlation.ldlt().solve(z)) / kNumCalibration;
  }
  return out;
}

}  // namespace facet
