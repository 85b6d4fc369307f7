// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/drawn_calibration.h"

#include <numbers>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

constexpr int kDraws = 60;

/// Root mean square, over the image and both axes, of how far the right camera is off where the
/// left one is believed, for points far away.
double RightAgainstLeft_px(const StereoRig& exact, const StereoRig& drawn) {
  double squares = 0;
  int count = 0;
  for (int y = 40; y < 480; y += 40) {
    for (int x = 40; x < 752; x += 40) {
      const Vector2d px(x, y);
      const Vector3d far_C0 = 1e6 * *exact.cameras[0].Unproject(px);
      const auto ray = drawn.cameras[0].Unproject(px);
      if (!ray) continue;
      const auto truth = exact.cameras[1].Project(exact.T_C1C0() * far_C0);
      const auto stated = drawn.cameras[1].Project(drawn.T_C1C0() * Vector3d(1e6 * *ray));
      if (!truth || !stated || !exact.cameras[1].IsInside(*truth, 0)) continue;
      squares += (*stated - *truth).squaredNorm();
      count += 2;
    }
  }
  return std::sqrt(squares / count);
}

std::vector<StereoRig> Draws(const DrawnParts& parts, int num) {
  std::vector<StereoRig> drawn;
  for (int seed = 1; seed <= num; ++seed)
    drawn.push_back(*DrawCalibration(EurocRig(), static_cast<std::uint64_t>(seed), parts));
  return drawn;
}

TEST(DrawnCalibrationTest, LensErrorsHaveTheCovarianceOfABoardCalibration) {
  const auto covariance = BoardCalibrationCovariance(EurocRig());
  ASSERT_TRUE(covariance);
  const Eigen::LDLT<RigMatrix> inverse(*covariance);
  double chi_square = 0;
  RigVector squares = RigVector::Zero();
  for (const StereoRig& drawn : Draws({true, false, false}, kDraws)) {
    const RigVector error = ParameterDifference(EurocRig(), drawn);
    chi_square += error.dot(inverse.solve(error)) / (kNumRigParameters * kDraws);
    squares += error.cwiseAbs2() / kDraws;
  }
  EXPECT_GT(chi_square, 0.7);
  EXPECT_LT(chi_square, 1.5);
  const RigVector ratio = squares.cwiseQuotient(covariance->diagonal());
  EXPECT_GT(ratio.minCoeff(), 0.4) << ratio.transpose();
  EXPECT_LT(ratio.maxCoeff(), 2.2) << ratio.transpose();
}

TEST(DrawnCalibrationTest, LeftAndRightAgreeBetterThanTheirMarginalsSay) {
  const StereoRig exact = EurocRig();
  double drawn_squares = 0, independent_squares = 0;
  const RigVector sigma = BoardCalibrationCovariance(exact)->diagonal().cwiseSqrt();
  Rng rng(3);
  for (const StereoRig& drawn : Draws({true, false, false}, kDraws)) {
    drawn_squares += std::pow(RightAgainstLeft_px(exact, drawn), 2) / kDraws;
    RigVector independent;
    for (int i = 0; i < kNumRigParameters; ++i)
      independent(i) = sigma(i) * rng.Normal();
    const StereoRig other = *ChangeParameters(exact, independent);
    independent_squares += std::pow(RightAgainstLeft_px(exact, other), 2) / kDraws;
  }
  EXPECT_NEAR(std::sqrt(drawn_squares), 0.2, 0.06) << "px";
  EXPECT_NEAR(std::sqrt(independent_squares), 0.9, 0.3) << "px";
}

TEST(DrawnCalibrationTest, CamerasAgainstTheImuAreOffByAsMuchAsStated) {
  const StereoRig exact = EurocRig();
  const DrawnCalibrationOptions options;
  double turns = 0, shifts = 0, times = 0;
  constexpr int kMany = 2000;
  for (const StereoRig& drawn : Draws({false, true, true}, kMany)) {
    const SE3 off = exact.T_BC[0].Inverse() * drawn.T_BC[0];
    turns += LogSO3(off.q).squaredNorm() / kMany;
    shifts += (drawn.T_BC[0].p - exact.T_BC[0].p).squaredNorm() / kMany;
    times += std::pow(ToSeconds(drawn.time_offset), 2) / kMany;
    EXPECT_LT(ParameterDifference(exact, drawn).norm(), 1e-9) << "between the cameras";
  }
  const double turn_deg = std::sqrt(turns) * 180 / std::numbers::pi;
  EXPECT_NEAR(turn_deg, options.imu_rotation_deg, 0.05 * options.imu_rotation_deg);
  EXPECT_NEAR(std::sqrt(shifts), options.imu_translation_m, 0.05 * options.imu_translation_m);
  EXPECT_NEAR(std::sqrt(times), options.time_s, 0.05 * options.time_s);
}

TEST(DrawnCalibrationTest, PartsAreTheSameWithAndWithoutTheOthers) {
  const StereoRig exact = EurocRig();
  const StereoRig all = *DrawCalibration(exact, 7);
  const StereoRig lens = *DrawCalibration(exact, 7, {true, false, false});
  const StereoRig imu = *DrawCalibration(exact, 7, {false, true, false});
  const StereoRig time = *DrawCalibration(exact, 7, {false, false, true});
  EXPECT_EQ(all.cameras[1].intrinsics().fx, lens.cameras[1].intrinsics().fx);
  EXPECT_EQ(lens.T_BC[0].p, exact.T_BC[0].p);
  EXPECT_EQ(lens.time_offset, exact.time_offset);
  EXPECT_LT((all.T_BC[0].p - imu.T_BC[0].p).norm(), 1e-15);
  EXPECT_EQ(imu.cameras[0].intrinsics().fx, exact.cameras[0].intrinsics().fx);
  EXPECT_EQ(time.T_BC[1].p, exact.T_BC[1].p);
  EXPECT_EQ(all.time_offset, time.time_offset);
  EXPECT_NE(time.time_offset.ns, 0);
}

TEST(DrawnCalibrationTest, ImuIsOffByAsMuchAsStatedAndTheCalibrationDoesNotKnow) {
  const DrawnCalibrationOptions options;
  double scale_squares = 0, turn_squares = 0;
  constexpr int kMany = 500;
  for (std::uint64_t seed = 1; seed <= kMany; ++seed) {
    const ImuErrors errors = DrawImuErrors(seed);
    for (const Matrix3d& M : {errors.of_gyro, errors.of_accel}) {
      const Matrix3d off = M - Matrix3d::Identity();
      scale_squares += off.diagonal().squaredNorm() / (6 * kMany);
      turn_squares += (off.squaredNorm() - off.diagonal().squaredNorm()) / (12 * kMany);
    }
  }
  EXPECT_NEAR(100 * std::sqrt(scale_squares), options.imu_scale_percent, 0.02);
  const double turn_deg = std::sqrt(turn_squares) * 180 / std::numbers::pi;
  EXPECT_NEAR(turn_deg, options.imu_misalignment_deg, 0.003);
  EXPECT_NE(DrawImuErrors(1).of_gyro, DrawImuErrors(1).of_accel);

  StereoRig exact = EurocRig();
  exact.gyro_scale = Vector3d(0.003, 0, 0);
  EXPECT_TRUE(DrawCalibration(exact, 1)->gyro_scale.isZero(0));
}

TEST(DrawnCalibrationTest, KnowsNothingOfWhatLensesDoBesideTheirModels) {
  StereoRig exact = EurocRig();
  exact.lens_modes[0].setConstant(0.05);
  for (const bool lens : {true, false})
    EXPECT_FALSE(DrawCalibration(exact, 1, {.lens = lens})->HasLensModes());
}

TEST(DrawnCalibrationTest, DiffersWithTheSeed) {
  const StereoRig exact = EurocRig();
  const double fx = DrawCalibration(exact, 1)->cameras[0].intrinsics().fx;
  EXPECT_EQ(fx, DrawCalibration(exact, 1)->cameras[0].intrinsics().fx);
  EXPECT_NE(fx, DrawCalibration(exact, 2)->cameras[0].intrinsics().fx);
}

}  // namespace
}  // namespace facet
