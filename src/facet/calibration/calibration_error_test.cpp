// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/calibration_error.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

TEST(CalibrationErrorTest, TheTrueOneHasNone) {
  const CalibrationError e = CompareCalibrations(EurocRig(), EurocRig());
  EXPECT_LT(e.error.norm(), 1e-12);
  EXPECT_LT(e.disparity_rms_px, 1e-9);
  EXPECT_FALSE(e.nees);
}

TEST(CalibrationErrorTest, APrincipalPointMovesAllDisparities) {
  StereoRig rig = EurocRig();
  CameraIntrinsics k = rig.cameras[1].intrinsics();
  k.cx += 0.25;
  k.cy -= 0.1;
  rig.cameras[1] = CameraModel(k);
  const CalibrationError e = CompareCalibrations(rig, EurocRig());
  EXPECT_NEAR(e.disparity_mean_px, 0.25, 1e-9);
  EXPECT_NEAR(e.disparity_rms_px, 0.25, 1e-9);
  EXPECT_NEAR(e.vertical_rms_px, 0.1, 1e-9);
  EXPECT_NEAR(e.error(kNumIntrinsics + 2), 0.25, 1e-12);
}

// A field that is the same in both images moves the two pixels of a far point alike; one that only
// the right lens has moves the disparities.
TEST(CalibrationErrorTest, WhatLensesDoBesideTheirModelsCounts) {
  StereoRig truth = EurocRig();
  truth.lens_modes[1].setConstant(0.05);
  EXPECT_LT(CompareCalibrations(truth, truth).disparity_rms_px, 1e-9);
  const CalibrationError e = CompareCalibrations(EurocRig(), truth);
  EXPECT_EQ(LensModesOf(e.error, 1), LensModeVector::Constant(-0.05));
  const double rms_px = std::hypot(e.disparity_rms_px, e.vertical_rms_px) / std::sqrt(2.0);
  EXPECT_NEAR(rms_px, 0.05 * std::sqrt(kNumLensModes), 0.04);
}

TEST(CalibrationErrorTest, TheCovarianceIsInTheSameOrder) {
  StereoRig rig = EurocRig();
  rig.time_offset = rig.time_offset + Duration{2'000'000};
  MatrixXd covariance = 1e-6 * MatrixXd::Identity(kNumCalibration, kNumCalibration);
  rig.covariance = std::make_shared<const MatrixXd>(covariance);
  EXPECT_NEAR(*CompareCalibrations(rig, EurocRig()).nees, 4.0 / kNumCalibration, 1e-6);
}

TEST(CalibrationErrorTest, TheMountMayBeOffByWhatTheAxesAre) {
  StereoRig rig = EurocRig();
  rig.T_BC[0] = rig.T_BC[0].Retract(Vector3d(0.002, 0, 0), Vector3d::Zero());
  rig.T_BC[1] = rig.T_BC[0] * EurocRig().T_C1C0().Inverse();
  MatrixXd covariance = 1e-6 * MatrixXd::Identity(kNumCalibration, kNumCalibration);
  rig.covariance = std::make_shared<const MatrixXd>(covariance);
  const double against_the_gyroscope = *CompareCalibrations(rig, EurocRig()).nees;
  rig.axes_sigma = std::sqrt(3e-6);
  EXPECT_NEAR(*CompareCalibrations(rig, EurocRig()).nees, 0.25 * against_the_gyroscope, 1e-4);
}

TEST(CalibrationErrorTest, WhatWasHeldHasNoNees) {
  StereoRig rig = EurocRig();
  rig.time_offset = rig.time_offset + Duration{2'000'000};
  CalibrationMatrix covariance = CalibrationMatrix::Identity();
  covariance.topLeftCorner<kNumLensColumns, kNumLensColumns>() *= kHeldSigma * kHeldSigma;
  covariance(kTimeOffset, kTimeOffset) = 1e-6;
  rig.covariance = std::make_shared<const MatrixXd>(covariance);
  constexpr int kNumEstimated = kNumCalibration - kNumLensColumns;
  EXPECT_NEAR(*CompareCalibrations(rig, EurocRig()).nees, 4.0 / kNumEstimated, 1e-6);
  rig.covariance =
      std::make_shared<const MatrixXd>(kHeldSigma * kHeldSigma * CalibrationMatrix::Identity());
  EXPECT_FALSE(CompareCalibrations(rig, EurocRig()).nees);
}

}  // namespace
}  // namespace facet
