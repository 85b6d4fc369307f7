// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/rough_lenses.h"

#include <array>
#include <cmath>

#include "facet/calibration/error_evidence.h"
#include "facet/calibration/intrinsics_jacobian.h"
#include "facet/calibration/rough_focal_lengths.h"
#include "facet/geometry/angles.h"

namespace facet {
namespace {

constexpr double kCentre_px = 5, kTurn = 0.3 * kDegree;
// By one coefficient of distortion, rms over the image.
constexpr double kDistortion_px = 1;
constexpr int kDistortion = 4, kNumDistortion = 4;  // among the intrinsics of a camera
// A Bayes factor of e^25: rough lenses are rare, and noise alone does not come near it.
constexpr double kClearEvidence = 50;
// What lenses do beside their models looks like another distortion, and has an evidence that grows
// as long as a run lasts: to half of this in ten seconds of MH_01
// (docs/notebook/calibration_online.md).
constexpr double kClearEvidenceForDistortion = 300;

/// By how much each coefficient moves points of the image, rms [px per unit].
Vector<kNumDistortion> MovesByDistortion(const CameraModel& camera) {
  constexpr std::array kPlaces = {0.1, 0.3, 0.5, 0.7, 0.9};  // shares of the image's sides
  Vector<kNumDistortion> squares = Vector<kNumDistortion>::Zero();
  int num = 0;
  for (const double x : kPlaces) {
    for (const double y : kPlaces) {
      const Vector2d px(x * camera.width(), y * camera.height());
      const auto ray = camera.Unproject(px);
      if (!ray) continue;
      const auto J = IntrinsicsJacobian(camera.intrinsics(), *ray, px);
      squares += J.middleCols<kNumDistortion>(kDistortion).colwise().squaredNorm().transpose();
      ++num;
    }
  }
  return num > 0 ? Vector<kNumDistortion>((squares / num).cwiseSqrt()) : squares;
}

CalibrationVector FocalLengthOf(const StereoRig& rig, int camera) {
  const int first = camera * kNumIntrinsics;
  CalibrationVector error = CalibrationVector::Zero();
  error.segment<2>(first) = RoughFocalLengths(rig).segment<2>(first);
  return error;
}

}  // namespace

std::vector<CalibrationVector> RoughPlaceErrors(const StereoRig& rig) {
  std::vector<CalibrationVector> errors;
  for (int c = 0; c < 2; ++c) {
    errors.push_back(FocalLengthOf(rig, c));
    for (int axis = 0; axis < 2; ++axis) {
      const int centre = c * kNumIntrinsics + kPrincipalPoint + axis;
      errors.push_back(kCentre_px * CalibrationVector::Unit(centre));
    }
  }
  for (int axis = 0; axis < 3; ++axis)
    errors.push_back(kTurn * CalibrationVector::Unit(kStereoRotation + axis));
  return errors;
}

namespace {

/// Nothing for coefficients that a lens does not have.
std::vector<CalibrationVector> ErrorsOfDistortion(const StereoRig& rig) {
  std::vector<CalibrationVector> errors;
  for (int c = 0; c < 2; ++c) {
    const auto moves = MovesByDistortion(rig.cameras[static_cast<std::size_t>(c)]);
    for (int i = 0; i < kNumDistortion; ++i) {
      const int coefficient = c * kNumIntrinsics + kDistortion + i;
      if (moves(i) > 0)
        errors.push_back(kDistortion_px / moves(i) * CalibrationVector::Unit(coefficient));
    }
  }
  return errors;
}

/// Two lenses of one make have one distortion.
CalibrationVector SameDistortion(const CalibrationVector& of_left) {
  CalibrationVector both = of_left;
  both.segment<kNumIntrinsics>(kNumIntrinsics) = of_left.head<kNumIntrinsics>();
  return both;
}

}  // namespace

std::vector<CalibrationVector> RoughLensErrors(const StereoRig& rig) {
  std::vector<CalibrationVector> errors = RoughPlaceErrors(rig);
  for (const CalibrationVector& error : ErrorsOfDistortion(rig))
    errors.push_back(error);
  return errors;
}

// A focal length of both cameras is not asked about: it has a rule of its own
// (rough_focal_lengths.h).
bool AreLensesRough(const StereoRig& rig,
                    const CalibrationMatrix& before,
                    const CalibrationVector& delta,
                    const CalibrationMatrix& left) {
  const auto is_there = [&](const CalibrationVector& error, double clear) {
    return JudgeError(error, before, delta, left).evidence > clear;
  };
  for (const CalibrationVector& error : RoughPlaceErrors(rig)) {
    if (is_there(error, kClearEvidence)) return true;
  }
  for (const CalibrationVector& error : ErrorsOfDistortion(rig)) {
    if (is_there(error, kClearEvidenceForDistortion)) return true;
    const bool is_of_left = !error.head<kNumIntrinsics>().isZero(0);
    if (is_of_left && is_there(SameDistortion(error), kClearEvidenceForDistortion)) return true;
  }
  return false;
}

}  // namespace facet
