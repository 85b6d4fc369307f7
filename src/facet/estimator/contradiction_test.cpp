// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/contradiction.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

struct Leg {
  ImuLink link;
  NavState begin, end;  // as the IMU has it
};

Leg MakeLeg() {
  Leg leg;
  leg.begin.t = Timestamp{1'400'000'000'000'000'000};
  leg.begin.v_WB = Vector3d(1, 0, 0);
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 40; ++i) {
    samples.push_back(
        {leg.begin.t + Duration{5'000'000 * i}, Vector3d(0, 0, 0.5), Vector3d(0.2, 0, kGravity)});
  }
  leg.link.measured = ImuPreintegration({}, {});
  leg.link.measured.Integrate(samples);
  leg.end = leg.link.measured.Predict(leg.begin);
  return leg;
}

TEST(ContradictionTest, WhatAgreesLeavesNoTrace) {
  const Leg leg = MakeLeg();
  Contradiction contradiction;
  contradiction.Add(leg.link, leg.begin, leg.end, 1.6);
  EXPECT_EQ(contradiction.CovarianceOf(leg.end).norm(), 0);
  EXPECT_FALSE(contradiction.IsRecentAt(leg.end.t));
}

TEST(ContradictionTest, TheStateIsUncertainByWhatTheyDifferIn) {
  const Leg leg = MakeLeg();
  NavState seen = leg.end;
  seen.T_WB.q = seen.T_WB.q * ExpSO3(Vector3d(0, 0, 0.05));
  seen.T_WB.p += Vector3d(0.1, 0, 0);
  seen.v_WB += Vector3d(0, 0.6, 0);
  Contradiction contradiction;
  contradiction.Add(leg.link, leg.begin, seen, 30);
  const auto sigma_at = [&](double s) {
    NavState x = seen;
    x.t = x.t + FromSeconds(s);
    return Vector<15>(contradiction.CovarianceOf(x).diagonal().cwiseSqrt());
  };
  EXPECT_NEAR(sigma_at(0)(2), 0.05, 1e-9);
  EXPECT_NEAR(sigma_at(0)(3), 0.1, 1e-9);
  EXPECT_NEAR(sigma_at(0)(7), 0.6, 1e-9);
  // The velocity moves on, for a while.
  EXPECT_NEAR(sigma_at(0.5)(4), 0.3, 0.03);
  EXPECT_NEAR(sigma_at(60)(4), 3, 0.01);
  EXPECT_LT(sigma_at(60)(7), 1e-4);
  EXPECT_TRUE(contradiction.IsRecentAt(leg.end.t + FromSeconds(0.9)));
  EXPECT_FALSE(contradiction.IsRecentAt(leg.end.t + FromSeconds(1.1)));
}

// A tilt that was wrong about the world's x axis is wrong about the body's y axis after a quarter
// turn.
TEST(ContradictionTest, ATurnedBodyHasItsTiltElsewhere) {
  const Leg leg = MakeLeg();
  NavState seen = leg.end;
  seen.T_WB.q = ExpSO3(Vector3d(0.05, 0, 0)) * seen.T_WB.q;
  Contradiction contradiction;
  contradiction.Add(leg.link, leg.begin, seen, 30);
  NavState level = leg.end, turned = leg.end;
  level.T_WB.q = Quaterniond::Identity();
  turned.T_WB.q = ExpSO3(Vector3d(0, 0, M_PI / 2));
  EXPECT_NEAR(std::sqrt(contradiction.CovarianceOf(level)(0, 0)), 0.05, 1e-9);
  EXPECT_NEAR(std::sqrt(contradiction.CovarianceOf(turned)(1, 1)), 0.05, 1e-9);
  EXPECT_NEAR(contradiction.CovarianceOf(turned)(0, 0), 0, 1e-12);
}

TEST(ContradictionTest, AWrongHeadingLeadsAstray) {
  const Leg leg = MakeLeg();
  NavState seen = leg.end;
  seen.T_WB.q = ExpSO3(Vector3d(0, 0, 0.1)) * seen.T_WB.q;
  Contradiction contradiction;
  contradiction.Add(leg.link, leg.begin, seen, 30);
  NavState later = seen;
  later.T_WB.p += Vector3d(5, 0, 0);
  EXPECT_NEAR(std::sqrt(contradiction.CovarianceOf(later)(4, 4)), 0.5, 0.01);
  EXPECT_LT(std::sqrt(contradiction.CovarianceOf(later)(3, 3)), 0.1);
}

TEST(ContradictionTest, AfterANewStartTiltAndVelocityAreNew) {
  const Leg leg = MakeLeg();
  NavState seen = leg.end;
  seen.T_WB.q = ExpSO3(Vector3d(0.05, 0, 0.1)) * seen.T_WB.q;
  seen.v_WB += Vector3d(0, 0.6, 0);
  Contradiction contradiction;
  contradiction.Add(leg.link, leg.begin, seen, 30);
  NavState later = seen;
  later.t = later.t + FromSeconds(1.5);
  later.T_WB.q = Quaterniond::Identity();
  const double moved_m = std::sqrt(contradiction.CovarianceOf(later)(4, 4));
  contradiction.StartOver(later.t);
  const Matrix<15, 15> covariance = contradiction.CovarianceOf(later);
  EXPECT_EQ(covariance(0, 0), 0);
  EXPECT_NEAR(std::sqrt(covariance(2, 2)), 0.1, 1e-9);
  EXPECT_NEAR(std::sqrt(covariance(4, 4)), moved_m, 1e-9);
  EXPECT_EQ(covariance(7, 7), 0);
}

TEST(ContradictionTest, NeighboursAddUp) {
  const Leg leg = MakeLeg();
  NavState seen = leg.end;
  seen.T_WB.p += Vector3d(0.1, 0, 0);
  Contradiction contradiction;
  for (int k = 0; k < 3; ++k)
    contradiction.Add(leg.link, leg.begin, seen, 10);
  EXPECT_NEAR(std::sqrt(contradiction.CovarianceOf(leg.end)(3, 3)), 0.3, 1e-9);
}

TEST(ContradictionTest, ATiltLeadsAstrayWithTheDistanceAndIsForgotten) {
  const Leg leg = MakeLeg();
  NavState x = leg.end;
  Contradiction contradiction;
  contradiction.AddTilt(x, 0.05);
  const auto tilt_of = [&](const NavState& state) {
    const Matrix3d R = state.T_WB.R();
    const Matrix3d in_W =
        R * contradiction.CovarianceOf(state).topLeftCorner<3, 3>() * R.transpose();
    EXPECT_NEAR(in_W(2, 2), 0, 1e-12);  // nothing is said of the heading
    return std::sqrt(in_W(0, 0));
  };
  const auto astray_of = [&](const NavState& state) {
    return std::sqrt(contradiction.CovarianceOf(state)(3, 3));
  };
  EXPECT_NEAR(tilt_of(x), 0.05, 1e-12);
  EXPECT_NEAR(astray_of(x), 0, 1e-12);
  x.T_WB.p += Vector3d(0, 0, 2);
  EXPECT_NEAR(astray_of(x), 0.1, 1e-12);
  contradiction.AddTilt(x, 0.01);  // less than what is left
  EXPECT_NEAR(tilt_of(x), 0.05, 1e-12);
  x.t = x.t + FromSeconds(60);
  x.T_WB.p += Vector3d(0, 0, 2);
  EXPECT_LT(tilt_of(x), 1e-6);
  EXPECT_NEAR(astray_of(x), 0.1, 1e-5);
  contradiction.StartOver(x.t);
  EXPECT_NEAR(astray_of(x), 0.1, 1e-5);
  contradiction.AddTilt(x, std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(contradiction.CovarianceOf(x).allFinite());
}

TEST(ContradictionTest, WhatIsNotFiniteIsLeftOut) {
  const Leg leg = MakeLeg();
  NavState broken = leg.end;
  broken.v_WB.x() = std::numeric_limits<double>::quiet_NaN();
  Contradiction contradiction;
  contradiction.Add(leg.link, leg.begin, broken, std::numeric_limits<double>::infinity());
  EXPECT_EQ(contradiction.CovarianceOf(leg.end).norm(), 0);
}

TEST(ContradictionTest, StaysFinite) {
  const Leg leg = MakeLeg();
  NavState seen = leg.end;
  seen.T_WB.p.x() = 1e200;
  seen.v_WB.y() = -1e200;
  seen.T_WB.q = seen.T_WB.q * ExpSO3(Vector3d(0, 0, 1));
  Contradiction contradiction;
  contradiction.Add(leg.link, leg.begin, seen, 1e100);
  EXPECT_TRUE(contradiction.CovarianceOf(leg.end).allFinite());
  EXPECT_NEAR(std::sqrt(contradiction.CovarianceOf(leg.end)(3, 3)), 1e4, 1e-3);
  NavState back = leg.end;
  back.T_WB.p.y() = 1e200;
  EXPECT_TRUE(contradiction.CovarianceOf(back).allFinite());
}

}  // namespace
}  // namespace facet
