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

/// Generators of the parts, which are the same whether the others are drawn or not.
struct PartSeeds {
  explicit PartSeeds(std::uint64_t seed) {
    Rng rng(seed);
    for (std::uint64_t* part : {&lens, &imu, &time, &scale})
      *part = rng.Next();
  }
  std::uint64_t lens, imu, time, scale;
};

}  // namespace

ImuErrors DrawImuErrors(double scale_percent, double misalignment_deg, Rng& rng) {
  const auto draw = [&] {
    Matrix3d M = Matrix3d::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        const double sigma = row == column ? scale_percent / 100 : misalignment_deg * kRadPerDeg;
        M(row, column) += sigma * rng.Normal();
      }
    }
    return M;
  };
  const Matrix3d of_gyro = draw(), of_accel = draw();
  return {of_gyro, of_accel};
}

ImuErrors DrawImuErrors(std::uint64_t seed, const DrawnCalibrationOptions& options) {
  Rng rng(PartSeeds(seed).scale);
  return DrawImuErrors(options.imu_scale_percent, options.imu_misalignment_deg, rng);
}

std::optional<StereoRig> DrawCalibration(const StereoRig& exact,
                                         std::uint64_t seed,
                                         const DrawnParts& parts,
                                         const DrawnCalibrationOptions& options) {
  const PartSeeds seeds(seed);
  Rng time_rng(seeds.time);
  StereoRig drawn = exact;
  // A calibration knows nothing of what lenses do beside their models.
  drawn.lens_modes = StereoRig().lens_modes;
  if (parts.scale) drawn.gyro_scale.setZero();
  if (parts.lens) {
    const auto calibrated = DrawLens(drawn, options.board, Rng(seeds.lens));
    if (!calibrated) return std::nullopt;
    drawn = *calibrated;
  }
  if (parts.imu) MoveCameras(options, Rng(seeds.imu), drawn);
  if (parts.time)
    drawn.time_offset = drawn.time_offset + FromSeconds(options.time_s * time_rng.Normal());
  return drawn;
}

}  // namespace facet
