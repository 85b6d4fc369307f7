// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/calibration_error.h"

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

CalibrationErrorOptions Enabled() {
  CalibrationErrorOptions options;
  options.enabled = true;
  return options;
}

/// Difference in the pixels of a camera where a board was seen (not at the left and right border),
/// after the turn and the scale that make it smallest: what the pose of a board cannot explain.
double UnexplainedRms(const CameraModel& a, const CameraModel& b) {
  Matrix4d H = 1e-9 * Matrix4d::Identity();
  Vector4d g = Vector4d::Zero();
  double squares = 0;
  int count = 0;
  for (int y = 20; y < a.height(); y += 40) {
    for (int x = a.width() / 8; x < a.width() * 7 / 8; x += 40) {
      const Vector2d xy = a.Undistort(Vector2d(x, y))->xy;
      const Vector3d ray(xy.x(), xy.y(), 1);
      Matrix<2, 3> J_px_p;
      const Vector2d r = *b.Project(ray, &J_px_p) - Vector2d(x, y);
      Matrix<2, 4> J;
      J << J_px_p * Hat(ray), J_px_p * Vector3d(xy.x(), xy.y(), 0);
      H += J.transpose() * J;
      g += J.transpose() * r;
      squares += r.squaredNorm();
      ++count;
    }
  }
  return std::sqrt((squares - g.dot(H.ldlt().solve(g))) / (2 * count));
}

TEST(CalibrationErrorTest, AsLargeAsInARealCalibration) {
  const StereoRig rig = EurocRig();
  double squares = 0;
  constexpr int kSeeds = 200;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const StereoRig measured = MeasureRig(rig, Enabled(), static_cast<std::uint64_t>(seed));
    for (std::size_t c = 0; c < 2; ++c)
      squares += std::pow(UnexplainedRms(rig.cameras[c], measured.cameras[c]), 2) / (2 * kSeeds);
  }
  EXPECT_NEAR(std::sqrt(squares), 0.13, 0.02) << "px, as studies/calibration_error.py prints";
}

TEST(CalibrationErrorTest, BothCamerasAgreeOnTheWhole) {
  // Independent errors of the principal points would shift all disparities by half a pixel.
  const StereoRig rig = EurocRig();
  double squares = 0;
  constexpr int kSeeds = 200;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const StereoRig measured = MeasureRig(rig, Enabled(), static_cast<std::uint64_t>(seed));
    double sum = 0;
    int count = 0;
    for (int y = 60; y < 480; y += 60) {
      for (int x = 60; x < 752; x += 60) {
        constexpr double kDepth_m = 4;
        const auto ray = measured.cameras[0].Unproject(Vector2d(x, y));
        const Vector3d p_C0 = kDepth_m * *rig.cameras[0].Unproject(Vector2d(x, y));
        const auto exact = rig.cameras[1].Project(rig.T_C1C0() * p_C0);
        const auto right =
            measured.cameras[1].Project(measured.T_C1C0() * Vector3d(p_C0.norm() * *ray));
        if (!exact || !right) continue;
        sum += right->x() - exact->x();
        ++count;
      }
    }
    squares += std::pow(sum / count, 2) / kSeeds;
  }
  EXPECT_LT(std::sqrt(squares), 0.06) << "px of disparity";
}

TEST(CalibrationErrorTest, OffsetsOfTheCamerasHaveTheirSigma) {
  const StereoRig rig = EurocRig();
  CalibrationErrorOptions options = Enabled();
  options.focal_px = options.center_px = options.radial = options.tangential = 0;
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
  CalibrationErrorOptions options = Enabled();
  const double fx = MeasureRig(rig, options, 1).cameras[0].intrinsics().fx;
  EXPECT_EQ(fx, MeasureRig(rig, options, 1).cameras[0].intrinsics().fx);
  EXPECT_NE(fx, MeasureRig(rig, options, 2).cameras[0].intrinsics().fx);
  options.enabled = false;
  EXPECT_EQ(rig.cameras[0].intrinsics().fx, MeasureRig(rig, options, 1).cameras[0].intrinsics().fx);
}

}  // namespace
}  // namespace facet
