// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/lens_modes.h"

#include <gtest/gtest.h>

#include "facet/calibration/intrinsics_jacobian.h"
#include "facet/calibration/lens_misfit.h"
#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

constexpr int kWidth = 752, kHeight = 480;

/// Calls f(px) for the middles of small squares that cover the image.
template <class Function>
int OverImage(const Function& f) {
  constexpr int kColumns = 150, kRows = 100;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      f(Vector2d((kWidth - 1) * (column + 0.5) / kColumns, (kHeight - 1) * (row + 0.5) / kRows));
    }
  }
  return kColumns * kRows;
}

TEST(LensModesTest, EachHasOnePixelAndSaysNothingOfTheOthers) {
  const LensModes modes(kWidth, kHeight);
  Matrix<kNumLensModes, kNumLensModes> products = Matrix<kNumLensModes, kNumLensModes>::Zero();
  const int num = OverImage([&](const Vector2d& px) {
    const auto at = modes.At(px);
    products += at.transpose() * at;
  });
  const auto expected = Matrix<kNumLensModes, kNumLensModes>::Identity();
  EXPECT_LT((products / (2 * num) - expected).cwiseAbs().maxCoeff(), 3e-3);
}

// A lens without distortion, whose axis is in the middle of the image: what its focal lengths,
// principal point, first radial and both tangential coefficients and turns of the camera do.
TEST(LensModesTest, SayNothingOfWhatAModelCanSay) {
  CameraIntrinsics k;
  k.width = kWidth;
  k.height = kHeight;
  k.fx = k.fy = 450;
  k.cx = 0.5 * (kWidth - 1);
  k.cy = 0.5 * (kHeight - 1);
  k.distortion = DistortionModel::kRadialTangential;
  const CameraModel camera(k);
  const LensModes modes(camera);
  constexpr int kSecondRadial = 5, kNum = kNumIntrinsics + 3;
  Matrix<kNumLensModes, kNum> products = Matrix<kNumLensModes, kNum>::Zero();
  Vector<kNum> squares = Vector<kNum>::Zero();
  const int num = OverImage([&](const Vector2d& px) {
    const Vector3d p_C = *camera.Unproject(px);
    const auto projected = ProjectWithDerivatives(camera, p_C);
    Matrix<2, kNum> J;
    J << projected->J_px_k, -projected->J_px_p * Hat(p_C);
    J.col(kSecondRadial).setZero();  // of fifth order
    products += modes.At(px).transpose() * J;
    squares += J.colwise().squaredNorm().transpose();
  });
  for (int c = 0; c < kNum; ++c) {
    const double size = std::sqrt(2 * num * squares(c)) + 1e-9;
    EXPECT_LT(products.col(c).norm() / size, 1e-3) << "column " << c;
  }
}

TEST(LensModesTest, SayMostOfALensThatDoesNotFollowItsModel) {
  const CameraModel camera = EurocRig().cameras[0];
  const LensModes modes(camera);
  double before = 0, after = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const LensMisfit misfit = LensMisfit::Draw(camera, 0.13, seed);
    const auto amounts = modes.Nearest([&](const Vector2d& px) { return misfit.At(px); });
    const SmoothField found = modes.Sum(amounts);
    OverImage([&](const Vector2d& px) {
      before += misfit.At(px).squaredNorm();
      after += (misfit.At(px) - found.At(px)).squaredNorm();
    });
  }
  EXPECT_LT(after, 0.2 * before);
}

TEST(LensModesTest, TheirSumIsThatOfTheirDisplacements) {
  const LensModes modes(640, 400);
  LensModeVector amounts;
  amounts << 0.1, -0.2, 0.3, 0.05, -0.15, 0.25, 0.01, -0.02, 0.4, 0.06;
  const SmoothField field = modes.Sum(amounts);
  for (const Vector2d& px : {Vector2d(0, 0), Vector2d(320, 200), Vector2d(600, 30)})
    EXPECT_LT((field.At(px) - modes.At(px) * amounts).norm(), 1e-12);
  EXPECT_LT((modes.Nearest([&](const Vector2d& px) { return field.At(px); }) - amounts).norm(),
            0.02 * amounts.norm());
}

}  // namespace
}  // namespace facet
