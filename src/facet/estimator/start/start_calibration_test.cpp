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
