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

const TurnCheck::Ratio kWrongTurns{0.99, 0.99, 0.001};
const Scale kConfirmed{1, 1, 0.003};

Matrix3d OfOrientation(const SizeDoubt& doubt, const NavState& x) {
  return doubt.CovarianceOf(x).topLeftCorner<3, 3>();
}

// Along a spiral, tilted.
NavState OnSpiral(double heading, double stretch = 1) {
  NavState x;
  constexpr double kStep = 1e-3;
  for (double h = 0; h < heading; h += kStep)
    x.T_WB.p +=
        kStep * (1 + 0.3 * h) *
        Vector3d(std::cos(stretch * (h + kStep / 2)), std::sin(stretch * (h + kStep / 2)), 0.1);
  x.T_WB.q = ExpSO3(Vector3d(0, 0, stretch * heading)) * ExpSO3(Vector3d(0.3, 0.4, 0));
  x.v_WB = 2 * Vector3d(std::cos(stretch * heading), std::sin(stretch * heading), 0.1);
  return x;
}

// The same flight with all turns about the vertical longer by 1e-4.
Vector<9> LongerTurns(double heading) {
  const NavState x = OnSpiral(heading), longer = OnSpiral(heading, 1 + 1e-4);
  Vector<9> error;
  error << LogSO3(x.T_WB.q.conjugate() * longer.T_WB.q), longer.T_WB.p - x.T_WB.p,
      longer.v_WB - x.v_WB;
  return 1e4 * error;
}

TEST(SizeDoubtTest, WrongTurnsLeadAstrayAsIfAllOfThemWereLonger) {
  SizeDoubt doubt, doubt_of_size;
  for (double heading = 0; heading < 9; heading += 0.05) {
    doubt.AddKeyframe(OnSpiral(heading), kConfirmed, kWrongTurns);
    doubt_of_size.AddKeyframe(OnSpiral(heading), kConfirmed, {});
  }
  const NavState x = OnSpiral(9);
  Matrix<15, 15> covariance = doubt.CovarianceOf(x);
  // Less what ways are wrong by.
  Vector<15> larger = Vector<15>::Zero();
  larger.segment<3>(3) = x.T_WB.p;
  larger.segment<3>(6) = x.v_WB;
  covariance -= SizeVariance(kConfirmed, kWrongTurns) * larger * larger.transpose();
  const Vector<9> longer = LongerTurns(9);
  const Matrix<9, 9> expected = DoubtOfTurns(kWrongTurns).variance * longer * longer.transpose();
  const Matrix<9, 9> found = covariance.topLeftCorner<9, 9>();
  EXPECT_LT((found - expected).norm(), 0.01 * expected.norm());
  EXPECT_NEAR(std::sqrt(found.topLeftCorner<3, 3>().trace()), 0.09, 0.015)
      << "not that of 9 - 2 pi";
  EXPECT_TRUE(OfOrientation(doubt_of_size, x).isZero());
}

TEST(SizeDoubtTest, WhereWrongTurnsHaveLedToStaysWhenTheCalibrationChanges) {
  SizeDoubt doubt;
  for (double heading = 0; heading < 3; heading += 0.05)
    doubt.AddKeyframe(OnSpiral(heading), kConfirmed, kWrongTurns);
  doubt.AddKeyframe(OnSpiral(3), kConfirmed, kWrongTurns);
  const Matrix<15, 15> before = doubt.CovarianceOf(OnSpiral(3));
  doubt.WorldHasChanged();
  const Matrix<15, 15> after = doubt.CovarianceOf(OnSpiral(3));
  const Matrix<6, 6> change = (after - before).topLeftCorner<6, 6>();
  EXPECT_LT(change.norm(), 1e-9 * before.norm());
  // Ten metres on, everything is turned by what the heading was wrong by.
  NavState on = OnSpiral(3);
  on.T_WB.p += Vector3d(10, 0, 0);
  const double heading_variance = DoubtOfTurns(kWrongTurns).variance * 9;
  const double gained = doubt.CovarianceOf(on)(4, 4) - after(4, 4);
  EXPECT_NEAR(gained / (100 * heading_variance), 1, 0.6);
}

TEST(SizeDoubtTest, NeitherTiltNorWhatWasTurnedWhileLostIsDoubted) {
  SizeDoubt doubt;
  // To and fro, with the pitch in phase: sums of rotation vectors do not come back.
  NavState x;
  for (double t = 0; t < 600; t += 0.1) {
    x.T_WB.q =
        ExpSO3(Vector3d(0, 0, 0.8 * std::sin(t))) * ExpSO3(Vector3d(0, 0.4 * std::cos(t), 0));
    doubt.AddKeyframe(x, kConfirmed, kWrongTurns);
  }
  EXPECT_LT(OfOrientation(doubt, x).trace(), 0.02 * 0.02);
  SizeDoubt lost;
  lost.AddKeyframe(OnSpiral(0), kConfirmed, kWrongTurns);
  lost.LoseState();
  NavState turned = OnSpiral(0);
  turned.T_WB.q = ExpSO3(Vector3d(0, 0, 2)) * turned.T_WB.q;
  lost.AddKeyframe(turned, kConfirmed, kWrongTurns);
  EXPECT_TRUE(OfOrientation(lost, turned).isZero(1e-20));
}

TEST(SizeDoubtTest, AHeadingIsAtMostUnknown) {
  SizeDoubt doubt;
  NavState x;
  for (double heading = 0; heading < 5000; heading += 1) {
    x.T_WB.q = ExpSO3(Vector3d(0, 0, heading));
    doubt.AddKeyframe(x, kConfirmed, kWrongTurns);
  }
  EXPECT_NEAR(OfOrientation(doubt, x).trace(), M_PI * M_PI / 3, 1e-9);
}

TEST(SizeDoubtTest, TurnsAreDoubtedOnceThereIsReasonTo) {
  EXPECT_EQ(DoubtOfTurns({}).variance, 0);
  EXPECT_LT(DoubtOfTurns(TurnCheck::Ratio{1.002, 1.002, 0.002}).share_wrong, 0.1);
  EXPECT_LT(DoubtOfTurns(TurnCheck::Ratio{0.97, 1.03, 0.002}).share_wrong, 0.2);
  EXPECT_NEAR(std::sqrt(DoubtOfTurns(TurnCheck::Ratio{1.01, 1.01, 0.002}).variance), 0.009, 0.002);
  SizeDoubt doubt;
  const auto sigma = [&](double heading, const TurnCheck::Ratio& turns) {
    doubt.AddKeyframe(OnSpiral(heading), kConfirmed, turns);
    return std::sqrt(OfOrientation(doubt, OnSpiral(heading)).trace());
  };
  EXPECT_EQ(sigma(0, {1.003, 1.003, 0.001}), 0);
  EXPECT_EQ(sigma(1, {1.003, 1.003, 0.001}), 0);
  EXPECT_GT(sigma(1.5, {1.009, 1.009, 0.001}), 0.01);
  EXPECT_GT(sigma(2, {1.0045, 1.0045, 0.001}), 0) << "still a little";
}

TEST(SizeDoubtTest, StatesThatAreNoNumbersAddNothing) {
  SizeDoubt doubt;
  doubt.WorldHasChanged();
  doubt.AddKeyframe(At(Vector3d::Constant(NAN)), {}, {});
  NavState no_orientation = At(Vector3d::Ones());
  no_orientation.T_WB.q.coeffs().setConstant(NAN);
  doubt.AddKeyframe(no_orientation, {}, {});
  EXPECT_TRUE(doubt.CovarianceOf(At(Vector3d::Ones())).isZero());
  doubt.AddKeyframe(At(Vector3d::Zero()), {}, {});
  EXPECT_TRUE(doubt.CovarianceOf(At(Vector3d::Constant(NAN))).isZero());
  EXPECT_TRUE(doubt.CovarianceOf(no_orientation).isZero());
  EXPECT_TRUE(doubt.CovarianceOf(At(Vector3d::Constant(1e300))).allFinite());
}

}  // namespace
}  // namespace facet
