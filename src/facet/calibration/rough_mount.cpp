// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/rough_mount.h"

#include "facet/calibration/rough_focal_lengths.h"
#include "facet/calibration/rough_lenses.h"
#include "facet/geometry/angles.h"

namespace facet {
namespace {

constexpr double kTurn = 0.5 * kDegree, kShift_m = 0.01;
// A Bayes factor of e^5, although there are six errors to be paid for: of right mounts it is
// negative.
constexpr double kClearMountEvidence = 10;
constexpr double kCommonCentre_px = 5, kClock_s = 0.01, kGyroscope = 0.01;

/// That may look like another mount: of lenses, pair, clock and gyroscope.
std::vector<CalibrationVector> OtherErrors(const StereoRig& rig) {
  std::vector<CalibrationVector> errors = RoughPlaceErrors(rig);
  errors.push_back(RoughFocalLengths(rig));
  // Images that were cropped otherwise than the calibration says.
  for (int axis = 0; axis < 2; ++axis) {
    const int left = kPrincipalPoint + axis, right = kNumIntrinsics + left;
    errors.push_back(kCommonCentre_px *
                     (CalibrationVector::Unit(left) + CalibrationVector::Unit(right)));
  }
  errors.push_back(kClock_s * CalibrationVector::Unit(kTimeOffset));
  for (int axis = 0; axis < 3; ++axis)
    errors.push_back(kGyroscope * CalibrationVector::Unit(kGyroScale + axis));
  return errors;
}

}  // namespace

std::vector<CalibrationVector> RoughMountErrors() {
  std::vector<CalibrationVector> errors;
  for (int axis = 0; axis < 3; ++axis) {
    errors.push_back(kTurn * CalibrationVector::Unit(kMountRotation + axis));
    errors.push_back(kShift_m * CalibrationVector::Unit(kMountTranslation + axis));
  }
  return errors;
}

std::optional<FreedEstimate> FindRoughMount(const StereoRig& rig,
                                            const CalibrationMatrix& before,
                                            const CalibrationVector& delta,
                                            const CalibrationMatrix& left) {
  const std::vector<CalibrationVector> mount = RoughMountErrors(), others = OtherErrors(rig);
  FreedEstimate freed = FreeErrors(mount, before, delta, left);
  if (!(freed.evidence > kClearMountEvidence)) return std::nullopt;
  // What other errors explain as well is none of the mount.
  const FreedEstimate explained = FreeErrors(others, before, delta, left);
  const CalibrationMatrix room = before + RoomForErrors(others, before);
  if (!(FreeErrors(mount, room, explained.delta, explained.left).evidence > kClearMountEvidence))
    return std::nullopt;
  return freed;
}

}  // namespace facet
