// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/window_measurement.h"

#include <cmath>

namespace facet {

namespace {

// Slopes are differences over this share of the distance.
constexpr double kSpan = 0.05;

}  // namespace

void SetCalibrationColumns(const WindowCalibration& calibration,
                           const BodyRates& rates,
                           const Vector3d& n_B,
                           WindowMeasurement& measurement) {
  const auto across = [&](const Vector3d& X_B) -> std::optional<Eigen::RowVectorXd> {
    const auto J = calibration.PointJacobian(X_B, rates);
    if (!J) return std::nullopt;
    return Eigen::RowVectorXd(n_B.transpose() * *J);
  };
  const auto at_centre = across(measurement.centre_B);
  if (!at_centre) return;
  Matrix<3, kNumCalibration> J;
  J.row(0) = *at_centre;
  const double span_m = kSpan * measurement.centre_B.norm();
  for (int k = 0; k < 2; ++k) {
    const Vector3d step_B = span_m * measurement.along_B[static_cast<std::size_t>(k)];
    const auto ahead = across(measurement.centre_B + step_B);
    const auto behind = across(measurement.centre_B - step_B);
    if (!ahead || !behind) return;
    J.row(1 + k) = (*ahead - *behind) / (2 * span_m);
  }
  measurement.J_calibration = J;
  measurement.measured_at = calibration.delta();
}

}  // namespace facet
