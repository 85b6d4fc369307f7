// SPDX-License-Identifier: BSD-2-Clause
// Calibrations with errors of one kind or another, of which images and gyroscope measure what they
// do in the first seconds: the images alone the focal lengths, badly, and both together how much
// the images turn for what the gyroscope says.
#include "facet/calibration/rough_focal_lengths.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/calibration/board_calibration.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

constexpr double kFocalSigma = 0.0015, kTurnSigma = 0.0007;

/// A careful calibration with these errors more.
struct Errors {
  double focal = 0;           ///< share of both focal lengths
  double focal_by_field = 0;  ///< what lenses make the images say of that, though it is not so
  Vector3d gyroscope = Vector3d::Zero();
};

class FirstSeconds {
 public:
  FirstSeconds(const Errors& errors, std::uint64_t seed) : rng_(seed), rig_(EurocRig()) {
    CalibrationMatrix believed = 1e-14 * CalibrationMatrix::Identity();
    believed.topLeftCorner<kNumRigParameters, kNumRigParameters>() +=
        *BoardCalibrationCovariance(rig_, {});
    believed.diagonal().segment<3>(kGyroScale).setConstant(0.003 * 0.003);
    before_ = believed.inverse();
    const CalibrationVector rough = RoughFocalLengths(rig_);
    const CalibrationMatrix root = believed.llt().matrixL();
    CalibrationVector truth = 100 * errors.focal * rough;
    for (int i = 0; i < kNumRigParameters; ++i)
      truth += rng_.Normal() * root.col(i);
    truth.segment<3>(kGyroScale) += errors.gyroscope;
    information_ = before_;
    // The share of both focal lengths in a calibration.
    const CalibrationVector share = 0.01 / rough.squaredNorm() * rough;
    Measure(share, share.dot(truth) + errors.focal_by_field, kFocalSigma);
    for (int axis = 0; axis < 2; ++axis) {
      const CalibrationVector turn = share + CalibrationVector::Unit(kGyroScale + axis);
      Measure(turn, turn.dot(truth), kTurnSigma);
    }
  }

  bool AreRough() const {
    const CalibrationMatrix left = information_.inverse();
    return AreFocalLengthsRough(rig_, before_, left * gradient_, left);
  }

 private:
  void Measure(const CalibrationVector& row, double value, double sigma) {
    information_ += row * row.transpose() / (sigma * sigma);
    gradient_ += row * (value + sigma * rng_.Normal()) / (sigma * sigma);
  }

  Rng rng_;
  StereoRig rig_;
  CalibrationMatrix before_, information_;
  CalibrationVector gradient_ = CalibrationVector::Zero();
};

int NumRough(const Errors& errors) {
  int num = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
    num += FirstSeconds(errors, seed).AreRough() ? 1 : 0;
  return num;
}

TEST(RoughFocalLengthsTest, OnePerCentIsSeen) {
  EXPECT_GE(NumRough({.focal = 0.01}), 95);
  EXPECT_GE(NumRough({.focal = -0.01}), 95);
}

TEST(RoughFocalLengthsTest, ACarefulCalibrationIsNotCalledRough) {
  EXPECT_EQ(NumRough({}), 0);
}

TEST(RoughFocalLengthsTest, NeitherIsAGyroscopeWithAnotherScale) {
  EXPECT_EQ(NumRough({.gyroscope = Vector3d::Constant(0.01)}), 0);
  EXPECT_EQ(NumRough({.gyroscope = Vector3d::Constant(-0.02)}), 0);
  EXPECT_EQ(NumRough({.gyroscope = Vector3d(0.03, 0, 0)}), 0);
  EXPECT_EQ(NumRough({.gyroscope = Vector3d::Constant(0.05)}), 0);
}

// As on the handheld recording of a real rig.
TEST(RoughFocalLengthsTest, NeitherIsALensThatDoesSomethingBesideItsModel) {
  EXPECT_EQ(NumRough({.focal_by_field = 0.01}), 0);
  EXPECT_EQ(NumRough({.focal_by_field = -0.015}), 0);
}

TEST(RoughFocalLengthsTest, WhatBothHaveInCommonIsTakenAwayAndNothingElse) {
  const StereoRig rig = EurocRig();
  const CalibrationVector rough = RoughFocalLengths(rig);
  const CameraIntrinsics& left = rig.cameras[0].intrinsics();
  EXPECT_DOUBLE_EQ(rough(0), 0.01 * left.fx);
  EXPECT_DOUBLE_EQ(rough(1), 0.01 * left.fy);
  EXPECT_LT(WithoutCommonFocalLength(rig, -0.7 * rough).norm(), 1e-12);
  CalibrationVector one = CalibrationVector::Zero();
  one.segment<2>(0) = rough.segment<2>(0);
  const CalibrationVector rest = WithoutCommonFocalLength(rig, one);
  EXPECT_NEAR(rest(0), 0.005 * left.fx, 1e-9) << "half of it is a difference between the cameras";
  EXPECT_NEAR(rest(kNumIntrinsics), -0.005 * rig.cameras[1].intrinsics().fx, 1e-9);
  EXPECT_EQ(WithoutCommonFocalLength(rig, CalibrationVector::Unit(kTimeOffset)),
            CalibrationVector::Unit(kTimeOffset));
}

}  // namespace
}  // namespace facet
