// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/calibration_error.h"

#include <gtest/gtest.h>

#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

/// Where both rigs see points 1 to 5 m ahead; difference in the pixels of a camera, after a turn of
/// the camera that makes it smallest: what no pose can explain.
double UnexplainedRms(const CameraModel& a, const CameraModel& b) {
  Vector3d turn = Vector3d::Zero();
  double rms = 0;
  for (int iteration = 0; iteration < 5; ++iteration) {
    Matrix3d H = 1e-9 * Matrix3d::Identity();
    Vector3d g = Vector3d::Zero();
    double squares = 0;
    int count = 0;
    for (int y = 20; y < a.height(); y += 40) {
      for (int x = 20; x < a.width(); x += 40) {
        const auto ray = a.Unproject(Vector2d(x, y));
        const Vector3d turned = ExpSO3(turn) * *ray;
        Matrix<2, 3> J_px_p;
        const auto px = b.Project(turned, &J_px_p);
        const Vector2d r = *px - Vector2d(x, y);
        const Matrix<2, 3> J = -J_px_p * Hat(turned);
        H += J.transpose() * J;
        g += J.transpose() * r;
        squares += 0.5 * r.squaredNorm();
        ++count;
      }
    }
    rms = std::sqrt(squares / count);
    turn -= H.ldlt().solve(g);
  }
  return rms;
}

TEST(CalibrationErrorTest, AsLargeAsInARealCalibration) {
  const StereoRig rig = EurocRig();
  double squares = 0;
  constexpr int kSeeds = 200;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const StereoRig measured = MeasureRig(rig, {}, static_cast<std::uint64_t>(seed));
    for (std::size_t c = 0; c < 2; ++c)
      squares += std::pow(UnexplainedRms(rig.cameras[c], measured.cameras[c]), 2) / (2 * kSeeds);
  }
  EXPECT_NEAR(std::sqrt(squares), 0.13, 0.03) << "px, as scripts/calibration_error.py prints";
}

TEST(CalibrationErrorTest, OffsetsOfTheCamerasHaveTheirSigma) {
  const StereoRig rig = EurocRig();
  const CalibrationErrorOptions options;
  constexpr int kSeeds = 400;
  Vector4d squares = Vector4d::Zero();
  for (int seed = 0; seed < kSeeds; ++seed) {
    const StereoRig measured = MeasureRig(rig, options, static_cast<std::uint64_t>(seed));
    const SE3 left = rig.T_BC[0].Inverse() * measured.T_BC[0];
    const SE3 between = rig.T_C1C0() * measured.T_C1C0().Inverse();
    squares += Vector4d(LogSO3(left.q).squaredNorm(),
                        left.p.squaredNorm(),
                        LogSO3(between.q).squaredNorm(),
                        between.p.squaredNorm()) /
               (3.0 * kSeeds);
  }
  const double deg = std::numbers::pi / 180;
  EXPECT_NEAR(std::sqrt(squares(0)), options.rotation_deg * deg, 0.1 * options.rotation_deg * deg);
  EXPECT_NEAR(std::sqrt(squares(1)), options.translation_m, 0.1 * options.translation_m);
  EXPECT_NEAR(std::sqrt(squares(2)),
              options.stereo_rotation_deg * deg,
              0.1 * options.stereo_rotation_deg * deg);
  EXPECT_LT(std::sqrt(squares(3)), 3 * options.stereo_translation_m);
}

TEST(CalibrationErrorTest, DiffersWithTheSeedAndCanBeSwitchedOff) {
  const StereoRig rig = EurocRig();
  CalibrationErrorOptions options;
  const double fx = MeasureRig(rig, options, 1).cameras[0].intrinsics().fx;
  EXPECT_EQ(fx, MeasureRig(rig, options, 1).cameras[0].intrinsics().fx);
  EXPECT_NE(fx, MeasureRig(rig, options, 2).cameras[0].intrinsics().fx);
  options.enabled = false;
  EXPECT_EQ(rig.cameras[0].intrinsics().fx, MeasureRig(rig, options, 1).cameras[0].intrinsics().fx);
}

}  // namespace
}  // namespace facet
