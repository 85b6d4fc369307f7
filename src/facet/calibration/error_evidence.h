// SPDX-License-Identifier: BSD-2-Clause
// Is a calibration wrong in one certain way by far more than was believed possible? What was
// measured answers that long before the estimate, which the belief holds back, has moved by much
// (docs/math.md, section 10.11).
#pragma once

#include <span>

#include "facet/calibration/calibration_vector.h"

namespace facet {

/// What becomes of an estimate if the calibration may also be wrong by `error` times a normal
/// number.
struct ErrorVerdict {
  /// Twice the logarithm of how much better what was measured is explained then. Without any
  /// measurement 0; negative where the error is not needed.
  double evidence = 0;
  CalibrationVector delta;  ///< the mean then
};

/// `before`: the information of what was believed; `delta` and `left`: mean and covariance of the
/// calibration with that belief and all that was measured.
ErrorVerdict JudgeError(const CalibrationVector& error,
                        const CalibrationMatrix& before,
                        const CalibrationVector& delta,
                        const CalibrationMatrix& left);

/// What becomes of an estimate if the calibration may also be wrong by several errors, each times a
/// normal number of its own.
struct FreedEstimate {
  double evidence = 0;  ///< as in ErrorVerdict
  CalibrationVector delta;
  CalibrationMatrix left;
};

/// Arguments as for JudgeError.
FreedEstimate FreeErrors(std::span<const CalibrationVector> errors,
                         const CalibrationMatrix& before,
                         const CalibrationVector& delta,
                         const CalibrationMatrix& left);

/// By how much less is believed if the calibration may also be wrong by `error` times a normal
/// number: a change of information, negative semidefinite.
CalibrationMatrix RoomForError(const CalibrationVector& error, const CalibrationMatrix& before);

/// By how much less is believed if the calibration may also be wrong by all of these errors, each
/// times a normal number of its own: a change of information, negative semidefinite.
CalibrationMatrix RoomForErrors(std::span<const CalibrationVector> errors,
                                const CalibrationMatrix& before);

}  // namespace facet
