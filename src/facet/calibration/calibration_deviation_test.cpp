// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/calibration_deviation.h"

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

class CalibrationDeviationTest : public ::testing::Test {
 protected:
  CalibrationDeviationTest() {
    prior_.diagonal().setConstant(1e-8);
    covariance_ = 1e-4 * prior_;
  }
  std::string Words() const { return InWords(GrossDeviations(rig_, delta_, covariance_, prior_)); }

  StereoRig rig_ = EurocRig();
  CalibrationVector delta_ = CalibrationVector::Zero();
  CalibrationMatrix prior_ = CalibrationMatrix::Zero(), covariance_;
};

TEST_F(CalibrationDeviationTest, NothingIsSaidOfSmallErrors) {
  delta_.setConstant(3e-4);  // three sigmas of each
  EXPECT_EQ(Words(), "");
}

TEST_F(CalibrationDeviationTest, NothingIsSaidOfWhatIsUncertain) {
  delta_(kTimeOffset) = 0.01;
  covariance_(kTimeOffset, kTimeOffset) = 0.003 * 0.003;
  EXPECT_EQ(Words(), "");
}

TEST_F(CalibrationDeviationTest, FocalLengthInPerCent) {
  const CameraIntrinsics& k = rig_.cameras[1].intrinsics();
  delta_(kNumIntrinsics) = 0.02 * k.fx;
  delta_(kNumIntrinsics + 1) = 0.02 * k.fy;
  EXPECT_EQ(Words(), "focal length of the right camera +2 %");
}

TEST_F(CalibrationDeviationTest, BaselineIsLongerInItsOwnDirection) {
  delta_.segment<3>(kStereoTranslation) = 0.02 * rig_.T_C1C0().p;
  const auto gross = GrossDeviations(rig_, delta_, covariance_, prior_);
  ASSERT_EQ(gross.size(), 1U);
  EXPECT_EQ(gross[0].what, "baseline");
  EXPECT_NEAR(gross[0].value, 2, 1e-9);
}

// What a careful calibration leaves of a turn about y it takes back in the principal point.
TEST_F(CalibrationDeviationTest, FarPointsShowATurnAboutYThatMayBeAPrincipalPoint) {
  const double f = rig_.cameras[1].intrinsics().fx;
  constexpr double kTurn = 1e-3;  // 1-sigma
  const int point = kNumIntrinsics + 2, turn = kStereoRotation + 1;
  prior_(turn, turn) += kTurn * kTurn;
  prior_(point, point) += f * f * kTurn * kTurn;
  prior_(turn, point) = prior_(point, turn) = -f * kTurn * kTurn;
  delta_(turn) = 2 * kTurn;
  EXPECT_EQ(Words(),
            "far points in the right image (a turn of that camera about y, or a principal point) "
            "+0.92 px");
  delta_(point) = -f * 2 * kTurn;
  EXPECT_EQ(Words(), "");
}

TEST_F(CalibrationDeviationTest, AnglesPlacesClockAndScales) {
  delta_(kStereoRotation + 2) = -0.2 * kDegree;
  delta_(kMountRotation) = 0.5 * kDegree;
  delta_(kMountTranslation + 1) = 0.012;
  delta_(kTimeOffset) = -0.01;
  delta_(kGyroScale + 2) = 0.01;
  EXPECT_EQ(
      Words(),
      "right camera against the left one about z -0.2 deg, cameras on the IMU about x +0.5 "
      "deg, cameras on the IMU along y +12 mm, time offset -10 ms, scale of the gyroscope about "
      "z +1 %");
}

}  // namespace
}  // namespace facet
