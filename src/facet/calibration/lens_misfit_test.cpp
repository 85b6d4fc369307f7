// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/lens_misfit.h"

#include <gtest/gtest.h>

#include "facet/calibration/board_calibration.h"
#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

constexpr double kRms_px = 0.13;

/// What is left of the displacement after the best change of intrinsics and direction, per axis.
double UnexplainedRms(const CameraModel& camera, const LensMisfit& misfit) {
  constexpr int kNum = kNumIntrinsics + 3;
  Matrix<kNum, kNum> H = 1e-9 * Matrix<kNum, kNum>::Identity();
  Vector<kNum> g = Vector<kNum>::Zero();
  double squares = 0;
  int count = 0;
  for (int y = 3; y < camera.height(); y += 9) {
    for (int x = 3; x < camera.width(); x += 9, count += 2) {
      const Vector3d p_C = *camera.Unproject(Vector2d(x, y));
      const auto d = ProjectWithDerivatives(camera, p_C);
      Matrix<2, kNum> J;
      J << d->J_px_k, -d->J_px_p * Hat(p_C);
      const Vector2d moved = misfit.At(Vector2d(x, y));
      H += J.transpose() * J;
      g += J.transpose() * moved;
      squares += moved.squaredNorm();
    }
  }
  return std::sqrt((squares - g.dot(H.ldlt().solve(g))) / count);
}

TEST(LensMisfitTest, NoParametersOfTheModelFit) {
  const StereoRig rig = EurocRig();
  for (const CameraModel& camera : rig.cameras) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const LensMisfit misfit = LensMisfit::Draw(camera, kRms_px, seed);
      EXPECT_NEAR(UnexplainedRms(camera, misfit), kRms_px, 0.03 * kRms_px);
    }
  }
}

TEST(LensMisfitTest, UndoFindsThePixelOfTheModel) {
  const CameraModel camera = EurocRig().cameras[0];
  const LensMisfit misfit = LensMisfit::Draw(camera, kRms_px, 3);
  for (const Vector2d& px : {Vector2d(10, 20), Vector2d(376, 240), Vector2d(740, 470)})
    EXPECT_LT((misfit.Undo(px + misfit.At(px)) - px).norm(), 1e-6);
}

TEST(LensMisfitTest, DiffersWithTheSeed) {
  const CameraModel camera = EurocRig().cameras[0];
  const Vector2d px(100, 100);
  const Vector2d first = LensMisfit::Draw(camera, kRms_px, 1).At(px);
  EXPECT_EQ(first, LensMisfit::Draw(camera, kRms_px, 1).At(px));
  EXPECT_NE(first, LensMisfit::Draw(camera, kRms_px, 2).At(px));
}

TEST(LensMisfitTest, OtherModelsHaveOneToo) {
  CameraIntrinsics k = EurocRig().cameras[0].intrinsics();
  k.distortion = DistortionModel::kNone;
  k.coefficients = {};
  const CameraModel pinhole(k);
  EXPECT_NEAR(
      UnexplainedRms(pinhole, LensMisfit::Draw(pinhole, kRms_px, 1)), kRms_px, 0.03 * kRms_px);
}

}  // namespace
}  // namespace facet
