// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/size_doubt.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

using Scale = ScaleCheck::Scale;

NavState At(const Vector3d& p, const Vector3d& v = Vector3d::Zero()) {
  NavState x;
  x.T_WB = SE3(ExpSO3(Vector3d(0.3, -0.2, 1)), p);
  x.v_WB = v;
  return x;
}

TEST(SizeDoubtTest, TheVarianceIsThatOfCalibrationsOfWhichOneInTenIsWrong) {
  Rng rng(1);
  constexpr double kSigma = 0.008, kAccelSigma = 0.003, kBin = 0.0015;
  constexpr double kMeasured[] = {0, 0.01, 0.02, 0.03};
  double squares[4] = {};
  int counts[4] = {};
  for (int i = 0; i < 2'000'000; ++i) {
    const double error = rng.Uniform(0, 1) < 0.1 ? 0.02 * rng.Normal() : 0;
    const double measured = error + std::hypot(kSigma, kAccelSigma) * rng.Normal();
    for (int k = 0; k < 4; ++k) {
      if (std::abs(measured - kMeasured[k]) > kBin) continue;
      squares[k] += error * error;
      ++counts[k];
    }
  }
  for (int k = 0; k < 4; ++k) {
    const double size = 1 + kMeasured[k];
    ASSERT_GT(counts[k], 1000);
    EXPECT_NEAR(SizeVariance(Scale{size, size, kSigma}, {}) / (squares[k] / counts[k]), 1, 0.1)
        << k;
  }
}

TEST(SizeDoubtTest, AConfirmedSizeIsHardlyDoubtedAndAContradictedOneByItsError) {
  const auto sigma = [](double size, double noise) {
    return std::sqrt(SizeVariance(Scale{size, size, noise}, {}));
  };
  EXPECT_NEAR(std::sqrt(SizeVariance({}, {})), 0.0063, 1e-4);
  EXPECT_LT(sigma(1, 0.003), 0.001);
  EXPECT_NEAR(sigma(1.02, 0.003), 0.02, 0.002);
  EXPECT_DOUBLE_EQ(sigma(0.98, 0.003), sigma(1.02, 0.003));
  EXPECT_GT(sigma(2, 0.01), 0.5) << "doubled";
  EXPECT_TRUE(std::isfinite(sigma(-1e6, 1e-9)));
}

// Turns that are as they should be take nothing away: the size has to be confirmed by itself.
TEST(SizeDoubtTest, TurnsThatAreOffMakeWaysDoubtful) {
  const Scale confirmed{1, 1, 0.003};
  const auto sigma = [&](double ratio) {
    return std::sqrt(SizeVariance(confirmed, TurnCheck::Ratio{ratio, ratio, 0.001}));
  };
  EXPECT_DOUBLE_EQ(sigma(1), std::sqrt(SizeVariance(confirmed, {})));
  EXPECT_NEAR(sigma(0.99), 0.01, 0.002);
  EXPECT_DOUBLE_EQ(sigma(0.99), sigma(1.01));
  EXPECT_EQ(SizeVariance({}, TurnCheck::Ratio{1, 1, 0.001}), SizeVariance({}, {}));
  for (const TurnCheck::Ratio& vague : {TurnCheck::Ratio{0.9, 1.2, 0.05}, {0.98, 1.04, 0.01}})
    EXPECT_LT(std::sqrt(SizeVariance(confirmed, vague)), 0.002) << vague.high;
}

TEST(SizeDoubtTest, WaysAndVelocitiesAreLongerOrShorterTogether) {
  SizeDoubt doubt;
  const Vector3d origin(5, -2, 1), way(3, 1, -2), v(0.5, 0, 1);
  EXPECT_TRUE(doubt.CovarianceOf(At(origin)).isZero());
  doubt.AddKeyframe(At(origin), {}, {});
  const Matrix<15, 15> covariance = doubt.CovarianceOf(At(origin + way, v));
  const double variance = SizeVariance({}, {});
  // The state of a world that is larger by 1e-3 about the origin.
  Vector<15> larger = Vector<15>::Zero();
  larger.segment<3>(3) = 1e-3 * way;
  larger.segment<3>(6) = 1e-3 * v;
  EXPECT_TRUE(covariance.isApprox(variance * 1e6 * larger * larger.transpose(), 1e-9));
  EXPECT_TRUE(doubt.CovarianceOf(At(origin)).isZero());
}

TEST(SizeDoubtTest, WhatIsKnownBetweenBoundsOnlyIsHardlyDoubtedMore) {
  const Scale brackets[] = {{1, 1.25, 0.014}, {1, 1.1, 0.01}, {0.95, 1, 0.005}, {0.5, 1, 0.016}};
  for (const Scale& scale : brackets)
    EXPECT_LT(std::sqrt(SizeVariance(scale, {})), 1.3 * std::sqrt(SizeVariance({}, {})))
        << scale.low << " to " << scale.high;
}

TEST(SizeDoubtTest, WhatCalibrationsHaveLedAstrayByStaysWhenTheyChange) {
  SizeDoubt doubt;
  doubt.AddKeyframe(At(Vector3d::Zero()), {}, {});
  const Vector3d way(4, 0, 0);
  const Scale wrong{1.02, 1.02, 0.002};
  doubt.AddKeyframe(At(way), wrong, {});
  const Matrix<15, 15> once = doubt.CovarianceOf(At(way));
  EXPECT_NEAR(std::sqrt(once(3, 3)), 0.08, 0.01);
  doubt.WorldHasChanged();
  EXPECT_TRUE(doubt.CovarianceOf(At(way)).isApprox(once, 1e-9));
  // The same way back with another error does not take the first one back.
  doubt.AddKeyframe(At(Vector3d::Zero()), wrong, {});
  doubt.WorldHasChanged();
  EXPECT_TRUE(doubt.CovarianceOf(At(Vector3d::Zero())).isApprox(2 * once, 1e-9));
}

TEST(SizeDoubtTest, StatesThatAreNoNumbersAddNothing) {
  SizeDoubt doubt;
  doubt.WorldHasChanged();
  doubt.AddKeyframe(At(Vector3d::Constant(NAN)), {}, {});
  EXPECT_TRUE(doubt.CovarianceOf(At(Vector3d::Ones())).isZero());
  doubt.AddKeyframe(At(Vector3d::Zero()), {}, {});
  EXPECT_TRUE(doubt.CovarianceOf(At(Vector3d::Constant(NAN))).isZero());
  EXPECT_TRUE(doubt.CovarianceOf(At(Vector3d::Constant(1e300))).allFinite());
}

}  // namespace
}  // namespace facet
