// SPDX-License-Identifier: BSD-2-Clause
// What is wrong with a calibration, in words and units that people use.
#pragma once

#include <string>
#include <vector>

#include "facet/calibration/calibration_vector.h"

namespace facet {

/// What is measured together, and wrong together, when a rig was not calibrated with care.
enum class CalibrationPart {
  kLenses,      ///< focal lengths, principal points, and the turn of the cameras against each other
  kDistortion,  ///< what lenses do besides
  kBaseline,    ///< the distance between the cameras
  kMount,       ///< the cameras on the IMU
  kClock,       ///< time offset of the cameras
  kGyroscope,   ///< scale of its axes
};

inline constexpr int kNumCalibrationParts = 6;

/// One thing that a calibration says.
struct CalibrationDeviation {
  CalibrationPart part = CalibrationPart::kLenses;
  std::string what;        ///< "focal length of the left camera"
  std::string unit;        ///< "%", "px", "deg", "mm", "ms"
  double value = 0;        ///< the true one less that of the calibration
  double sigma = 0;        ///< 1-sigma of `value` now
  double prior_sigma = 0;  ///< 1-sigma of `value` before anything was measured
};

/// Focal lengths, principal points, baseline, directions, places, clock and scale of the gyroscope.
/// `delta`: how far they are from `nominal`; the covariances: of `delta` now and before anything
/// was measured.
std::vector<CalibrationDeviation> CalibrationDeviations(const StereoRig& nominal,
                                                        const CalibrationVector& delta,
                                                        const CalibrationMatrix& covariance,
                                                        const CalibrationMatrix& prior);

/// Those that no careful calibration leaves, and that are certain.
std::vector<CalibrationDeviation> GrossDeviations(const StereoRig& nominal,
                                                  const CalibrationVector& delta,
                                                  const CalibrationMatrix& covariance,
                                                  const CalibrationMatrix& prior);

/// "focal length of the left camera +1.0 %, time offset -10.2 ms"
std::string InWords(const std::vector<CalibrationDeviation>& deviations);

}  // namespace facet
