// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/rough_focal_lengths.h"

#include <algorithm>

#include <Eigen/Cholesky>

#include "facet/calibration/error_evidence.h"

namespace facet {
namespace {

constexpr double kRough = 0.01;
// A Bayes factor of e^12.5: rough focal lengths are rare, and noise alone does not come near it.
constexpr double kClearEvidence = 25;
// Over that of a gyroscope whose scale is wrong by as much.
constexpr double kClearlyMore = 6;
// By which the gyroscope must agree better, in squared sigmas, and what may be left of them.
constexpr double kAgreesBetter = 1, kLeftOfIt = 0.5;

double FocalLengthShare(const StereoRig& rig, const CalibrationVector& delta) {
  double share = 0;
  for (int c = 0; c < 2; ++c) {
    const CameraIntrinsics& k = rig.cameras[static_cast<std::size_t>(c)].intrinsics();
    const auto change = delta.segment<2>(c * kNumIntrinsics);
    share += 0.25 * (change(0) / k.fx + change(1) / k.fy);
  }
  return share;
}

/// Of any one axis, or of all of them.
double EvidenceForGyroscope(const CalibrationMatrix& before,
                            const CalibrationVector& delta,
                            const CalibrationMatrix& left) {
  CalibrationVector all = CalibrationVector::Zero();
  all.segment<3>(kGyroScale).setConstant(kRough);
  double evidence = JudgeError(all, before, delta, left).evidence;
  for (int axis = 0; axis < 3; ++axis) {
    const CalibrationVector one = kRough * CalibrationVector::Unit(kGyroScale + axis);
    evidence = std::max(evidence, JudgeError(one, before, delta, left).evidence);
  }
  return evidence;
}

}  // namespace

CalibrationVector RoughFocalLengths(const StereoRig& rig) {
  CalibrationVector lengths = CalibrationVector::Zero();
  for (int c = 0; c < 2; ++c) {
    const CameraIntrinsics& k = rig.cameras[static_cast<std::size_t>(c)].intrinsics();
    lengths.segment<2>(c * kNumIntrinsics) << kRough * k.fx, kRough * k.fy;
  }
  return lengths;
}

CalibrationVector WithoutCommonFocalLength(const StereoRig& rig, const CalibrationVector& delta) {
  return delta - FocalLengthShare(rig, delta) / kRough * RoughFocalLengths(rig);
}

// Lenses that do something beside their model can have as much evidence. Then the gyroscope agreed
// before and would not any more.
bool AreFocalLengthsRough(const StereoRig& rig,
                          const CalibrationMatrix& before,
                          const CalibrationVector& delta,
                          const CalibrationMatrix& left) {
  const ErrorVerdict rough = JudgeError(RoughFocalLengths(rig), before, delta, left);
  if (rough.evidence < kClearEvidence) return false;
  if (rough.evidence < EvidenceForGyroscope(before, delta, left) + kClearlyMore) return false;
  const Eigen::LLT<Matrix3d> known(left.block<3, 3>(kGyroScale, kGyroScale));
  const auto error_of_gyroscope = [&](const CalibrationVector& calibration) {
    const Vector3d scale = calibration.segment<3>(kGyroScale);
    return scale.dot(Vector3d(known.solve(scale)));
  };
  const double error = error_of_gyroscope(delta), error_then = error_of_gyroscope(rough.delta);
  return error_then + kAgreesBetter < error && error_then < kLeftOfIt * error;
}

}  // namespace facet
