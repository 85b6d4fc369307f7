// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/calibration_vector.h"

#include <cstdio>

#include "facet/geometry/so3.h"

namespace facet {

CalibrationVector CalibrationDifference(const StereoRig& from, const StereoRig& to) {
  CalibrationVector delta;
  delta.head<kNumRigParameters>() = ParameterDifference(from, to);
  for (std::size_t c = 0; c < 2; ++c)
    LensModesOf(delta, static_cast<int>(c)) = to.lens_modes[c] - from.lens_modes[c];
  const SE3 mount = to.T_BC[0] * from.T_BC[0].Inverse();
  delta.segment<3>(kMountRotation) = LogSO3(mount.q);
  delta.segment<3>(kMountTranslation) = mount.p;
  delta(kTimeOffset) = ToSeconds(to.time_offset) - ToSeconds(from.time_offset);
  delta.segment<3>(kGyroScale) = to.gyro_scale - from.gyro_scale;
  return delta;
}

void ForgetLensModes(CalibrationMatrix& covariance) {
  covariance.middleRows(kLensModes, 2 * kNumLensModes).setZero();
  covariance.middleCols(kLensModes, 2 * kNumLensModes).setZero();
}

bool SaysNothingOfLensModes(const CalibrationMatrix& covariance) {
  return covariance.diagonal().segment(kLensModes, 2 * kNumLensModes).isZero(0);
}

bool AreHeld(const CalibrationMatrix& covariance, int first, int count) {
  constexpr double kMargin = 3;
  return covariance.diagonal().segment(first, count).maxCoeff() <
         kMargin * kMargin * kHeldSigma * kHeldSigma;
}

namespace {

// A standard deviation may be so small, in the unit of its parameter: what an estimator holds has
// 1e-7.
constexpr double kLeastSigma = 1e-9;

// And so large: what would still be of some use. Coefficients of distortion are powers of an angle,
// of which a narrow lens knows next to nothing.
struct Most {
  double sigma;
  const char* unit;
};

Most MostOf(int parameter) {
  constexpr Most kPixels{1e3, " px"}, kLength{10, " m"}, kAngle{3, " rad"}, kTime{1, " s"},
      kShare{1, ""}, kDistortion{1e6, ""};
  if (parameter < kStereoRotation) return parameter % kNumIntrinsics < 4 ? kPixels : kDistortion;
  if (parameter < kStereoTranslation) return kAngle;
  if (parameter < kLensModes) return kLength;
  if (parameter < kMountRotation) return kPixels;
  if (parameter < kMountTranslation) return kAngle;
  if (parameter < kTimeOffset) return kLength;
  return parameter == kTimeOffset ? kTime : kShare;
}

std::string OutOfBounds(const CalibrationVector& sigmas) {
  for (int k = 0; k < kNumCalibration; ++k) {
    const Most most = MostOf(k);
    if (sigmas(k) >= kLeastSigma && sigmas(k) <= most.sigma) continue;
    char text[200];
    std::snprintf(text,
                  sizeof(text),
                  "the standard deviation of %s is %.3g%s, where %.0g to %.0g are possible",
                  kCalibrationNames[static_cast<std::size_t>(k)],
                  sigmas(k),
                  most.unit,
                  kLeastSigma,
                  most.sigma);
    return text;
  }
  return "";
}

}  // namespace

std::string WhatIsWrong(const CalibrationMatrix& of_all) {
  CalibrationMatrix covariance = of_all;
  if (SaysNothingOfLensModes(of_all))
    covariance.diagonal().segment(kLensModes, 2 * kNumLensModes).setOnes();
  if (!covariance.allFinite()) return "a covariance has finite numbers";
  if (!(covariance.diagonal().minCoeff() > 0)) return "a covariance has a positive diagonal";
  const CalibrationVector sigmas = covariance.diagonal().cwiseSqrt();
  if (const std::string problem = OutOfBounds(sigmas); !problem.empty()) return problem;
  const CalibrationVector scale = sigmas.cwiseInverse();
  const CalibrationMatrix correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  Eigen::Index row = 0, column = 0;
  if (!((correlation - correlation.transpose()).cwiseAbs().maxCoeff(&row, &column) < 1e-6)) {
    const auto name = [](Eigen::Index k) { return kCalibrationNames[static_cast<std::size_t>(k)]; };
    return std::string("a covariance is symmetric, but that of ") + name(row) + " and " +
           name(column) + " is another one the other way round";
  }
  if (correlation.ldlt().vectorD().minCoeff() <= 0) return "a covariance is positive definite";
  return "";
}

}  // namespace facet
