// SPDX-License-Identifier: BSD-2-Clause
// Calibrations with errors of one kind or another, of which far points measure where the right
// camera sees what the left one sees.
#include "facet/calibration/rough_lenses.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/calibration/board_calibration.h"
#include "facet/calibration/error_evidence.h"
#include "facet/calibration/lens_modes.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

constexpr double kMisfit_px = 0.13, kSigma_px = 0.05;

CalibrationMatrix Believed(const StereoRig& rig) {
  CalibrationMatrix believed = 1e-14 * CalibrationMatrix::Identity();
  believed.topLeftCorner<kNumRigParameters, kNumRigParameters>() +=
      *BoardCalibrationCovariance(rig, {});
  believed.diagonal()
      .segment<2 * kNumLensModes>(kLensModes)
      .setConstant(kMisfit_px * kMisfit_px / kNumLensModes);
  return believed;
}

// Where the right camera sees what the left one sees far away at px.
Vector2d FarInRight(const StereoRig& rig, const Vector2d& px) {
  return *rig.cameras[1].Project(rig.T_C1C0().q * *rig.cameras[0].Unproject(px));
}

class FarPoints {
 public:
  FarPoints(const CalibrationVector& error, double misfit_px, std::uint64_t seed)
      : rng_(seed), rig_(EurocRig()) {
    const CalibrationMatrix believed = Believed(rig_);
    before_ = believed.inverse();
    const CalibrationMatrix root = believed.llt().matrixL();
    CalibrationVector truth = error;
    for (int i = 0; i < kNumRigParameters; ++i)
      truth += rng_.Normal() * root.col(i);
    truth.segment<2 * kNumLensModes>(kLensModes) =
        misfit_px / std::sqrt(1.0 * kNumLensModes) *
        Vector<2 * kNumLensModes>::NullaryExpr([&] { return rng_.Normal(); });
    information_ = before_;
    for (int i = 0; i < 60; ++i)
      Measure({rng_.Uniform(60, 690), rng_.Uniform(40, 440)}, truth);
  }

  bool AreRough() const {
    const CalibrationMatrix left = information_.inverse();
    return AreLensesRough(rig_, before_, left * gradient_, left);
  }

 private:
  void Measure(const Vector2d& px, const CalibrationVector& truth) {
    Matrix<2, kNumCalibration> J = Matrix<2, kNumCalibration>::Zero();
    for (int k = 0; k < kNumRigParameters; ++k) {
      constexpr double kStep = 1e-6;
      const auto changed = ChangeParameters(rig_, kStep * RigVector::Unit(k));
      J.col(k) = (FarInRight(*changed, px) - FarInRight(rig_, px)) / kStep;
    }
    J.middleCols<kNumLensModes>(kLensModes + kNumLensModes) =
        LensModes(rig_.cameras[1]).At(FarInRight(rig_, px));
    for (int axis = 0; axis < 2; ++axis) {
      const CalibrationVector row = J.row(axis);
      information_ += row * row.transpose() / (kSigma_px * kSigma_px);
      gradient_ += row * (row.dot(truth) + kSigma_px * rng_.Normal()) / (kSigma_px * kSigma_px);
    }
  }

  Rng rng_;
  StereoRig rig_;
  CalibrationMatrix before_, information_;
  CalibrationVector gradient_ = CalibrationVector::Zero();
};

int NumRough(const CalibrationVector& error, double misfit_px = 0) {
  int num = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    num += FarPoints(error, misfit_px, seed).AreRough() ? 1 : 0;
  return num;
}

TEST(RoughLensesTest, ACarefulCalibrationIsNotCalledRough) {
  EXPECT_EQ(NumRough(CalibrationVector::Zero()), 0);
}

TEST(RoughLensesTest, NeitherIsOneOfLensesThatDoSomethingBesideTheirModels) {
  EXPECT_EQ(NumRough(CalibrationVector::Zero(), kMisfit_px), 0);
  EXPECT_EQ(NumRough(CalibrationVector::Zero(), 2 * kMisfit_px), 0);
}

TEST(RoughLensesTest, EachErrorIsSeen) {
  const std::vector<CalibrationVector> errors = RoughLensErrors(EurocRig());
  ASSERT_EQ(errors.size(), 6u + 3u + 8u);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    // Radial distortion of either lens must be clearly more than what lenses do beside their
    // models; tangential one is not told from other errors by far points alone.
    const bool is_radial = i == 9 || i == 13;
    if (i >= 9 && !is_radial) continue;
    const CalibrationVector error = (is_radial ? 3 : 1) * errors[i];
    EXPECT_GE(NumRough(error), 19) << i;
    EXPECT_GE(NumRough(-error, kMisfit_px), 19) << i;
  }
}

TEST(RoughLensesTest, ALensWithoutDistortionHasNoneThatIsWrong) {
  StereoRig rig = EurocRig();
  for (CameraModel& camera : rig.cameras) {
    CameraIntrinsics k = camera.intrinsics();
    k.distortion = DistortionModel::kNone;
    k.coefficients = {};
    camera = CameraModel(k);
  }
  EXPECT_EQ(RoughLensErrors(rig).size(), 6u + 3u);
}

// One after the other they are what their sum is.
TEST(RoughLensesTest, RoomForErrorsIsThatOfTheSumOfTheirVariances) {
  const StereoRig rig = EurocRig();
  const CalibrationMatrix believed = Believed(rig);
  CalibrationMatrix possible = believed;
  const std::vector<CalibrationVector> errors = RoughLensErrors(rig);
  for (const CalibrationVector& error : errors)
    possible += error * error.transpose();
  const CalibrationVector scale = believed.diagonal().cwiseSqrt();
  const auto in_sigmas = [&](const CalibrationMatrix& information) -> CalibrationMatrix {
    return scale.asDiagonal() * information * scale.asDiagonal();
  };
  const CalibrationMatrix before = believed.inverse();
  const CalibrationMatrix now = before + RoomForErrors(errors, before);
  EXPECT_LT(in_sigmas(now - possible.inverse()).norm(), 1e-6 * in_sigmas(before).norm());
  const Eigen::SelfAdjointEigenSolver<CalibrationMatrix> eigen(in_sigmas(now));
  EXPECT_GT(eigen.eigenvalues()(0), 0);
}

}  // namespace
}  // namespace facet
