// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/drawn_calibration.h"

#include <cmath>
#include <numbers>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;

std::optional<StereoRig> DrawLens(const StereoRig& exact,
                                  const BoardCalibrationOptions& options,
                                  Rng rng) {
  const std::vector<BoardView> views = MakeUpBoardViews(exact, options.board, rng);
  if (views.empty()) return std::nullopt;
  return CalibrateWithBoard(exact, views, DetectCorners(exact, views, options, rng));
}

/// A vector whose length has this root mean square.
Vector3d DrawVector(double length, Rng& rng) {
  return length / std::sqrt(3.0) * rng.Normal3();
}

/// Turns both cameras about the left one and moves them, as one rigid piece.
void MoveCameras(const DrawnCalibrationOptions& options, Rng rng, StereoRig& rig) {
  const SE3 T_C0C1 = rig.T_BC[0].Inverse() * rig.T_BC[1];
  const Vector3d turn = DrawVector(options.imu_rotation_deg * kRadPerDeg, rng);
  const Vector3d shift = DrawVector(options.imu_translation_m, rng);
  rig.T_BC[0] = rig.T_BC[0].Retract(turn, shift);
  rig.T_BC[1] = rig.T_BC[0] * T_C0C1;
}

}  // namespace

std::optional<StereoRig> DrawCalibration(const StereoRig& exact,
                                         std::uint64_t seed,
                                         const DrawnParts& parts,
                                         const DrawnCalibrationOptions& options) {
  Rng rng(seed);
  const Rng lens_rng(rng.Next()), imu_rng(rng.Next());
  Rng time_rng(rng.Next());
  StereoRig drawn = exact;
  // A calibration knows nothing of what lenses do beside their models.
  drawn.lens_modes = StereoRig().lens_modes;
  if (parts.lens) {
    const auto calibrated = DrawLens(drawn, options.board, lens_rng);
    if (!calibrated) return std::nullopt;
    drawn = *calibrated;
  }
  if (parts.imu) MoveCameras(options, imu_rng, drawn);
  if (parts.time)
    drawn.time_offset = drawn.time_offset + FromSeconds(options.time_s * time_rng.Normal());
  return drawn;
}

}  // namespace facet
