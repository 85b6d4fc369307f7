// SPDX-License-Identifier: BSD-2-Clause
// A measurement of a plane in the window, and what the calibration does to it.
#pragma once

#include "facet/estimator/window/window_calibration.h"
#include "facet/map/plane_measurement.h"

namespace facet {

struct WindowMeasurement : PlaneMeasurement {
  WindowMeasurement(const PlaneMeasurement& measurement)  // NOLINT(google-explicit-constructor)
      : PlaneMeasurement(measurement) {}

  /// d (distance at the centre [m], slopes [rad]) / d calibration, and the deviation of the
  /// calibration with which it was measured.
  Matrix<3, kNumCalibration> J_calibration = Matrix<3, kNumCalibration>::Zero();
  CalibrationVector measured_at = CalibrationVector::Zero();
};

/// Sets both, for a plane with the normal n_B. The measurement is left without columns where a
/// camera does not see the plane at its centre.
void SetCalibrationColumns(const WindowCalibration& calibration,
                           const BodyRates& rates,
                           const Vector3d& n_B,
                           WindowMeasurement& measurement);

}  // namespace facet
