// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/rough_mount.h"

#include "facet/geometry/angles.h"

namespace facet {
namespace {

constexpr double kTurn = 0.5 * kDegree, kShift_m = 0.01;
// A Bayes factor of e^5, over six errors that all have to be paid for: without them it is -5 to
// -15.
constexpr double kClearMountEvidence = 10;

}  // namespace

std::vector<CalibrationVector> RoughMountErrors() {
  std::vector<CalibrationVector> errors;
  for (int axis = 0; axis < 3; ++axis) {
    errors.push_back(kTurn * CalibrationVector::Unit(kMountRotation + axis));
    errors.push_back(kShift_m * CalibrationVector::Unit(kMountTranslation + axis));
  }
  return errors;
}

std::optional<FreedEstimate> FindRoughMount(const CalibrationMatrix& before,
                                            const CalibrationVector& delta,
                                            const CalibrationMatrix& left) {
  FreedEstimate freed = FreeErrors(RoughMountErrors(), before, delta, left);
  if (!(freed.evidence > kClearMountEvidence)) return std::nullopt;
  return freed;
}

}  // namespace facet
