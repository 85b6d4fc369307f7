// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/window_calibration.h"

#include <gtest/gtest.h>

#include "facet/camera/stereo_triangulation.h"
#include "facet/estimator/window/frame_geometry.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

LensModeVector Modes(double scale) {
  LensModeVector modes;
  modes << 0.5, -0.4, 0.3, 0.2, -0.5, 0.4, -0.3, -0.2, 0.6, 0.1;
  return scale * modes;
}

/// Estimated of a rig whose lenses have `nominal` beside their models, and off by `delta`.
SlidingWindow WindowWith(const LensModeVector& nominal, const LensModeVector& delta) {
  StereoRig rig = EurocRig();
  rig.lens_modes = {nominal, -nominal};
  SlidingWindow window(rig.T_BC[0]);
  window.calibration.emplace(rig, CalibrationMatrix::Identity());
  CalibrationVector change = CalibrationVector::Zero();
  LensModesOf(change, 0) = delta;
  LensModesOf(change, 1) = -delta;
  window.calibration->SetDelta(change);
  return window;
}

// What a former run has estimated counts as what this one adds to it.
TEST(WindowCalibrationTest, GivenAndEstimatedModesOfALensAddUp) {
  const SlidingWindow both = WindowWith(Modes(0.3), Modes(0.7));
  const SlidingWindow given = WindowWith(Modes(1), Modes(0));
  FrameGeometry of_both(EurocRig()), of_given(EurocRig());
  of_both.Update(both);
  of_given.Update(given);
  const Vector3d h(0.3, -0.2, 1);
  for (int c = 0; c < 2; ++c) {
    const Vector2d seen_px = *of_both.present_lens(c).Project(h);
    const Vector2d by_model_px = *EurocRig().cameras[static_cast<std::size_t>(c)].Project(h);
    EXPECT_LT((seen_px - *of_given.present_lens(c).Project(h)).norm(), 1e-12);
    EXPECT_GT((seen_px - by_model_px).norm(), 0.1);
    const LensModeVector refined =
        both.calibration->Refined().lens_modes[static_cast<std::size_t>(c)];
    EXPECT_LT((refined - (c == 0 ? 1.0 : -1.0) * Modes(1)).norm(), 1e-12);
  }
}

TEST(WindowCalibrationTest, APointMovesWithTheModesAsATriangulatedOneDoes) {
  StereoRig rig = EurocRig();
  const Vector3d p_C0(0.8, -0.4, 2.5);
  const Vector2d left_px = *rig.cameras[0].Project(p_C0);
  const Vector2d right_px = *rig.cameras[1].Project(rig.T_C1C0() * p_C0);
  const auto triangulate = [&](const std::array<LensModeVector, 2>& modes) -> Vector3d {
    rig.lens_modes = modes;
    const LensFields fields = FieldsOf(rig);
    const auto left = rig.cameras[0].Unproject(ByModel(fields, 0, left_px));
    const auto right = rig.cameras[1].BearingOf(ByModel(fields, 1, right_px));
    const auto stereo = TriangulateOnRay(*left, *right, rig.T_C1C0());
    return rig.T_BC[0] * Vector3d(*left / stereo->inverse_distance);
  };
  WindowCalibration calibration(EurocRig(), CalibrationMatrix::Identity());
  const auto J = calibration.PointJacobian(rig.T_BC[0] * p_C0, BodyRates{});
  ASSERT_TRUE(J);
  constexpr double kStep_px = 1e-3;
  for (int c = 0; c < 2; ++c) {
    for (int k = 0; k < kNumLensModes; ++k) {
      std::array<LensModeVector, 2> ahead = {LensModeVector::Zero(), LensModeVector::Zero()};
      ahead[static_cast<std::size_t>(c)](k) = kStep_px;
      const std::array<LensModeVector, 2> behind = {-ahead[0], -ahead[1]};
      const Vector3d slope = (triangulate(ahead) - triangulate(behind)) / (2 * kStep_px);
      const Vector3d column = J->col(kLensModes + c * kNumLensModes + k);
      EXPECT_LT((column - slope).norm(), 1e-3 * slope.norm() + 1e-6) << c << " " << k;
    }
  }
  calibration.SettleModes(true);
  const auto settled = calibration.PointJacobian(rig.T_BC[0] * p_C0, BodyRates{});
  ASSERT_TRUE(settled);
  EXPECT_TRUE(settled->middleCols<2 * kNumLensModes>(kLensModes).isZero(0));
  EXPECT_EQ(settled->leftCols<kLensModes>(), J->leftCols<kLensModes>());
}

}  // namespace
}  // namespace facet
