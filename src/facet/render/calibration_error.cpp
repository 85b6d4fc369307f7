// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/calibration_error.h"

#include <numbers>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;

CameraModel MeasureCamera(const CameraModel& camera,
                          const CalibrationErrorOptions& options,
                          Rng& rng) {
  CameraIntrinsics k = camera.intrinsics();
  k.fx += options.focal_px * rng.Normal();
  k.fy += options.focal_px * rng.Normal();
  k.cx += options.center_px * rng.Normal();
  k.cy += options.center_px * rng.Normal();
  const std::array<double, 4> sigmas = {
      options.radial, options.radial, options.tangential, options.tangential};
  for (std::size_t i = 0; i < sigmas.size() && k.distortion != DistortionModel::kNone; ++i)
    k.coefficients[i] += sigmas[i] * rng.Normal();
  return CameraModel::WhatIsWrong(k).empty() ? CameraModel(k) : camera;
}

/// The turn of the measured camera's rays that brings its pixels nearest to those of the exact one.
/// A calibration finds both together: what its principal point is off, its rotation makes up for.
Quaterniond CompensatingTurn(const CameraModel& exact, const CameraModel& measured) {
  constexpr int kStep_px = 40, kRounds = 3;
  Quaterniond turn = Quaterniond::Identity();
  for (int round = 0; round < kRounds; ++round) {
    Matrix3d H = 1e-9 * Matrix3d::Identity();
    Vector3d g = Vector3d::Zero();
    for (int y = kStep_px / 2; y < exact.height(); y += kStep_px) {
      for (int x = kStep_px / 2; x < exact.width(); x += kStep_px) {
        const auto ray = exact.Unproject(Vector2d(x, y));
        if (!ray) continue;
        const Vector3d turned = turn * *ray;
        Matrix<2, 3> J_px_p;
        const auto px = measured.Project(turned, &J_px_p);
        if (!px) continue;
        const Matrix<2, 3> J = -J_px_p * Hat(turned);
        H += J.transpose() * J;
        g += J.transpose() * (*px - Vector2d(x, y));
      }
    }
    turn = ExpSO3(-H.ldlt().solve(g)) * turn;
  }
  return turn;
}

SE3 DrawOffset(double rotation_deg, double translation_m, Rng& rng) {
  const Vector3d turn = rotation_deg * kRadPerDeg * rng.Normal3();
  return SE3(ExpSO3(turn), translation_m * rng.Normal3());
}

}  // namespace

StereoRig MeasureRig(const StereoRig& rig,
                     const CalibrationErrorOptions& options,
                     std::uint64_t seed) {
  if (!options.enabled) return rig;
  Rng rng(seed);
  StereoRig measured = rig;
  for (CameraModel& camera : measured.cameras)
    camera = MeasureCamera(camera, options, rng);
  const SE3 common = DrawOffset(options.rotation_deg, options.translation_m, rng);
  const SE3 between = DrawOffset(options.stereo_rotation_deg, options.stereo_translation_m, rng);
  // About the cameras' own places: a rotation about the body's origin would move them too.
  for (std::size_t c = 0; c < 2; ++c) {
    const Quaterniond turn = CompensatingTurn(rig.cameras[c], measured.cameras[c]);
    SE3& T_BC = measured.T_BC[c];
    T_BC = SE3(common.q * T_BC.q * turn.conjugate(), T_BC.p + common.p);
  }
  measured.T_BC[1] = measured.T_BC[1] * between;
  return measured;
}

}  // namespace facet
