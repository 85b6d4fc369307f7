// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/start/start_calibration.h"

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

// A run writes what it begins with, or less, and reads it back.
TEST(StartCovarianceTest, OfWhatIsHeldCanBeReadBack) {
  const StereoRig rig = testing::MakeTestRig();
  for (bool CalibrationOptions::*held : {&CalibrationOptions::lens,
                                         &CalibrationOptions::mount,
                                         &CalibrationOptions::time,
                                         &CalibrationOptions::gyro}) {
    CalibrationOptions options;
    EXPECT_EQ(WhatIsWrong(StartCovariance(rig, options)), "");
    options.*held = false;
    EXPECT_EQ(WhatIsWrong(StartCovariance(rig, options)), "");
  }
}

// What a run held is not known any better after it.
TEST(StartCovarianceTest, WhatTheFormerRunHeldIsAsAfterACarefulCalibration) {
  StereoRig rig = testing::MakeTestRig();
  const CalibrationMatrix careful = StartCovariance(rig, {});
  CalibrationOptions held;
  held.lens = held.time = false;
  rig.covariance = std::make_shared<const MatrixXd>(1e-4 * StartCovariance(rig, held) +
                                                    0.9999 * kHeldSigma * kHeldSigma *
                                                        CalibrationMatrix::Identity());
  const CalibrationMatrix now = StartCovariance(rig, {});
  const auto ratio = [&](int k) { return std::sqrt(now(k, k) / careful(k, k)); };
  EXPECT_NEAR(ratio(0), 1, 1e-6);
  EXPECT_NEAR(ratio(kStereoRotation), 1, 1e-3);
  EXPECT_NEAR(ratio(kLensModes), 1, 1e-6);
  EXPECT_NEAR(ratio(kTimeOffset), 1, 1e-3);
  EXPECT_LT(ratio(kMountRotation), 0.2);
  EXPECT_LT(ratio(kGyroScale), 0.2);
}

// A narrow lens hardly has an angle to the third power, and none to the ninth.
TEST(StartCovarianceTest, OfANarrowLensCanBeReadBack) {
  StereoRig rig = testing::MakeTestRig();
  for (CameraModel& camera : rig.cameras) {
    CameraIntrinsics k = camera.intrinsics();
    k.fx = k.fy = 1200;
    k.distortion = DistortionModel::kEquidistant;
    k.coefficients = {};
    camera = CameraModel(k);
  }
  CalibrationOptions options;
  options.board_noise_px = 5;
  EXPECT_EQ(WhatIsWrong(StartCovariance(rig, options)), "");
}

}  // namespace
}  // namespace facet
