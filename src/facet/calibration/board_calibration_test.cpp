// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/board_calibration.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "facet/sim/euroc_rig.h"
#include "facet/testing/lens_examples.h"

namespace facet {
namespace {

TEST(BoardViewsTest, BothCamerasSeeMostOfTheBoard) {
  Rng rng(5);
  const StereoRig rig = EurocRig();
  const std::vector<BoardView> views = MakeUpBoardViews(rig, {}, rng);
  ASSERT_EQ(views.size(), 40u);
  for (const BoardView& view : views) {
    for (std::size_t c = 0; c < 2; ++c) {
      EXPECT_GE(view.corners[c].size(), 36u);
      for (const Vector3d& corner : view.corners[c]) {
        const SE3 T_C_board = c == 0 ? view.T_C0_board : rig.T_C1C0() * view.T_C0_board;
        const auto px = rig.cameras[c].Project(T_C_board * corner);
        ASSERT_TRUE(px);
        EXPECT_TRUE(rig.cameras[c].IsInside(*px, 0));
      }
    }
  }
}

TEST(BoardViewsTest, CamerasWithoutACommonViewHaveNone) {
  StereoRig rig = EurocRig();
  rig.T_BC[1].q = rig.T_BC[1].q * Quaterniond(0, 0, 1, 0);  // looks backwards
  Rng rng(5);
  BoardOptions options;
  options.num_views = 1;
  EXPECT_TRUE(MakeUpBoardViews(rig, options, rng).empty());
  EXPECT_FALSE(BoardCalibrationCovariance(rig, {options}));
}

TEST(BoardCalibrationTest, WithoutErrorsFindsTheExactRigFromAWrongOne) {
  const StereoRig exact = EurocRig();
  Rng rng(2);
  BoardCalibrationOptions options;
  options.corner_noise_px = 0;
  const std::vector<BoardView> views = MakeUpBoardViews(exact, options.board, rng);
  const std::vector<DetectedView> detected = DetectCorners(exact, views, options, rng);
  RigVector wrong = RigVector::Zero();
  wrong << 5, -3, 4, 2, 0.01, -0.01, 1e-3, -1e-3, -2, 3, -4, 1, 0.01, 0, 0, 0, 0.01, -0.01, 0.005,
      2e-3, -1e-3, 1e-3;
  const auto found = CalibrateWithBoard(*ChangeParameters(exact, wrong), views, detected);
  ASSERT_TRUE(found);
  EXPECT_LT(ParameterDifference(exact, *found).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(BoardCalibrationTest, CovarianceScalesWithTheSquareOfTheNoise) {
  BoardCalibrationOptions options;
  const auto usual = BoardCalibrationCovariance(EurocRig(), options);
  options.corner_noise_px *= 2;
  const auto twice = BoardCalibrationCovariance(EurocRig(), options);
  ASSERT_TRUE(usual && twice);
  EXPECT_LT((*twice - 4 * *usual).norm(), 1e-9 * twice->norm());
  const Eigen::SelfAdjointEigenSolver<RigMatrix> solver(*usual);
  EXPECT_GT(solver.eigenvalues().minCoeff(), 0);
}

// What every lens must allow before it is estimated: a calibration by a board finds it, and the
// covariance of that is one.
TEST(BoardCalibrationTest, EveryLensCanBeCalibrated) {
  for (const CameraIntrinsics& lens : testing::LensExamples()) {
    const int num = std::min<int>(4, static_cast<int>(NumCoefficients(lens.distortion)));
    StereoRig rig = EurocRig();
    rig.cameras.fill(CameraModel(lens));
    BoardCalibrationOptions options;
    const auto covariance = BoardCalibrationCovariance(rig, options);
    ASSERT_TRUE(covariance) << NumCoefficients(lens.distortion);
    EXPECT_TRUE(covariance->allFinite());
    const RigVector sigma = covariance->diagonal().cwiseSqrt();
    for (int c = 0; c < 2; ++c) {
      const auto of_camera = sigma.segment<kNumIntrinsics>(c * kNumIntrinsics);
      EXPECT_GT(of_camera.head(4 + num).minCoeff(), 0);
      EXPECT_EQ(of_camera.tail(4 - num).norm(), 0);
    }
    // From three sigmas off in everything that can be seen by itself.
    options.corner_noise_px = 0;
    Rng rng(4);
    const std::vector<BoardView> views = MakeUpBoardViews(rig, options.board, rng);
    const std::vector<DetectedView> detected = DetectCorners(rig, views, options, rng);
    const Eigen::LLT<RigMatrix> factor(*covariance + 1e-18 * RigMatrix::Identity());
    const RigVector off = factor.matrixL() * RigVector::Constant(3 / std::sqrt(22.0));
    const auto wrong = ChangeParameters(rig, off);
    ASSERT_TRUE(wrong);
    const auto found = CalibrateWithBoard(*wrong, views, detected);
    ASSERT_TRUE(found);
    const RigVector left = ParameterDifference(rig, *found);
    for (int i = 0; i < kNumRigParameters; ++i)
      EXPECT_LT(std::abs(left(i)), 1e-3 * sigma(i) + 1e-6) << i;
  }
}

TEST(BoardCalibrationTest, CoefficientsThatALensDoesNotHaveAreHeld) {
  StereoRig rig = EurocRig();
  CameraIntrinsics k = rig.cameras[1].intrinsics();
  k.distortion = DistortionModel::kNone;
  k.coefficients = {};
  rig.cameras[1] = CameraModel(k);
  const auto covariance = BoardCalibrationCovariance(rig);
  ASSERT_TRUE(covariance);
  EXPECT_TRUE(covariance->allFinite());
  EXPECT_EQ((covariance->middleRows<4>(kNumIntrinsics + 4).norm()), 0);
  EXPECT_GT((*covariance)(kNumIntrinsics, kNumIntrinsics), 0);
}

}  // namespace
}  // namespace facet
