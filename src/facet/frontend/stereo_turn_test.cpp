// SPDX-License-Identifier: BSD-2-Clause
// Made-up matches with noise and mismatches.
#include "facet/frontend/stereo_turn.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

std::vector<StereoRays> Matches(const StereoRig& rig, int num, Rng& rng) {
  std::vector<StereoRays> matches;
  const double noise = 0.2 / rig.cameras[1].mean_focal_px();
  while (static_cast<int>(matches.size()) < num) {
    const double z = rng.Uniform(1, 6);
    const Vector3d p_C0(z * rng.Uniform(-0.7, 0.7), z * rng.Uniform(-0.45, 0.45), z);
    const Vector3d p_C1 = rig.T_C1C0() * p_C0;
    StereoRays rays{p_C0.normalized(), p_C1.normalized()};
    rays.right += noise * Vector3d(rng.Normal(), rng.Normal(), 0);
    if (rng.Uniform() < 0.15) rays.right.y() += rng.Uniform(-0.01, 0.01);
    matches.push_back(rays);
  }
  return matches;
}

TEST(StereoTurnTest, FindsTurnsAboutXAndZ) {
  Rng rng(1);
  const StereoRig rig = EurocRig();
  for (int axis : {0, 2}) {
    for (const double degrees : {-0.5, -0.2, 0.2, 0.5}) {
      const Vector3d omega = degrees * kDegree * Vector3d::Unit(axis);
      const auto matches = Matches(TurnedRig(rig, omega), 300, rng);
      const StereoTurn turn = EstimateStereoTurn(rig, matches);
      EXPECT_TRUE(turn.IsClear()) << axis << " " << degrees << " " << turn.before_px << " "
                                  << turn.after_px;
      EXPECT_LT((turn.omega - omega).norm(), 0.05 * kDegree) << axis << " " << degrees;
    }
  }
}

// The matches do not tell; what they seem to say by chance would go into every depth.
TEST(StereoTurnTest, SaysNothingAboutY) {
  Rng rng(5);
  const StereoRig rig = EurocRig();
  for (int i = 0; i < 10; ++i) {
    const StereoRig turned = TurnedRig(rig, Vector3d(0.3 * kDegree, 0, 0));
    const StereoTurn turn = EstimateStereoTurn(rig, Matches(turned, 300, rng));
    EXPECT_LT(std::abs(turn.omega.y()), 3e-3 * kDegree) << i;
  }
}

TEST(StereoTurnTest, ACarefulCalibrationIsLeftAlone) {
  Rng rng(2);
  const StereoRig rig = EurocRig();
  for (int i = 0; i < 50; ++i) {
    const Vector3d omega = 0.015 * kDegree * rng.Normal3();
    const StereoTurn turn = EstimateStereoTurn(rig, Matches(TurnedRig(rig, omega), 300, rng));
    EXPECT_FALSE(turn.IsClear()) << i << " " << turn.before_px << " " << turn.after_px;
  }
}

TEST(StereoTurnTest, FewMatchesProveNothing) {
  Rng rng(3);
  const StereoRig rig = EurocRig();
  const Vector3d omega(0.5 * kDegree, 0, 0);
  EXPECT_FALSE(EstimateStereoTurn(rig, Matches(TurnedRig(rig, omega), 40, rng)).IsClear());
  EXPECT_FALSE(EstimateStereoTurn(rig, {}).IsClear());
}

TEST(StereoTurnTest, AnotherErrorThanATurnIsLeftAlone) {
  Rng rng(4);
  const StereoRig rig = EurocRig();
  std::vector<StereoRays> matches = Matches(rig, 300, rng);
  for (StereoRays& rays : matches)
    rays.right.y() += rng.Uniform(-0.01, 0.01);
  EXPECT_FALSE(EstimateStereoTurn(rig, matches).IsClear());
}

}  // namespace
}  // namespace facet
