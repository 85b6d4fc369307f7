// SPDX-License-Identifier: BSD-2-Clause
// Made-up turns with noise, a bias, a mount that is off by half a degree and a clock by 20 ms.
#include "facet/plausibility/gyroscope_check.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kTurn_s = 0.2;

// EuRoC's: 90 deg about z.
Quaterniond TrueMount() {
  return ExpSO3(Vector3d(0.01, 0.02, 90 * kDegree));
}

// A body that turns about some axes by a sum of oscillations.
class Turns {
 public:
  Turns(const Vector3d& amplitude, std::uint64_t seed) : amplitude_(amplitude), rng_(seed) {
    for (int k = 0; k < 3; ++k)
      phase_[k] = rng_.Uniform(0, 6);
  }

  // As measured by a gyroscope that is M times what it should be.
  SharedTurn Next(const Matrix3d& M) {
    const Vector3d w_B = Rate(t_s_), w_late_B = Rate(t_s_ - 0.02);
    t_s_ += kTurn_s;
    const Quaterniond R_CB =
        TrueMount().conjugate() * ExpSO3(0.5 * kDegree * Vector3d(0.6, -0.6, 0.5));
    SharedTurn turn;
    turn.image.covariance = 4e-6 * Matrix3d::Identity();
    turn.image.theta = kTurn_s * (R_CB * w_B) + 2e-3 * rng_.Normal3();
    if (rng_.Uniform() < 0.1) turn.image.theta += 0.2 * rng_.Normal3();
    turn.gyro_B = kTurn_s * (M * (w_late_B + Vector3d(-0.02, 0.02, 0.08)));
    turn.duration_s = kTurn_s;
    return turn;
  }

 private:
  Vector3d Rate(double t_s) const {
    Vector3d w;
    for (int k = 0; k < 3; ++k)
      w[k] = amplitude_[k] * std::sin(2.5 * (1 + 0.3 * k) * t_s + phase_[k]);
    return w;
  }

  Vector3d amplitude_, phase_ = Vector3d::Zero();
  Rng rng_;
  double t_s_ = 0;
};

struct GyroscopeVerdict {
  double after_s = 0;
  std::string words;
  bool is_convinced = false;
};

GyroscopeVerdict Judge(const Matrix3d& M,
                       const Vector3d& amplitude,
                       std::uint64_t seed,
                       const Quaterniond& R_BC = TrueMount(),
                       double duration_s = 60) {
  GyroscopeCheck check(R_BC);
  Turns turns(amplitude, seed);
  GyroscopeVerdict verdict;
  while (verdict.after_s < duration_s && verdict.words.empty() && !check.IsConvinced()) {
    verdict.words = check.Add(turns.Next(M));
    verdict.after_s += kTurn_s;
  }
  verdict.is_convinced = check.IsConvinced();
  return verdict;
}

TEST(GyroscopeCheckTest, IsConvincedOfARightOne) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const GyroscopeVerdict verdict = Judge(Matrix3d::Identity(), Vector3d(0.6, 0.6, 0.6), seed);
    EXPECT_THAT(verdict.words, IsEmpty()) << seed;
    EXPECT_TRUE(verdict.is_convinced) << seed;
    EXPECT_LT(verdict.after_s, 12) << seed;
  }
}

TEST(GyroscopeCheckTest, DoesNotKnowOfAxesThatDoNotTurn) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const GyroscopeVerdict verdict = Judge(Matrix3d::Identity(), Vector3d(0.6, 0.02, 0.02), seed);
    EXPECT_THAT(verdict.words, IsEmpty()) << seed;
    EXPECT_FALSE(verdict.is_convinced) << seed;
  }
}

TEST(GyroscopeCheckTest, NamesNegatedAxes) {
  for (int axis = 0; axis < 3; ++axis) {
    Matrix3d M = Matrix3d::Identity();
    M(axis, axis) = -1;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const GyroscopeVerdict verdict = Judge(M, Vector3d(0.6, 0.6, 0.6), seed);
      const std::string name(1, static_cast<char>('x' + axis));
      EXPECT_THAT(verdict.words, HasSubstr("axis " + name + " were negated")) << seed;
      EXPECT_LT(verdict.after_s, 6) << seed;
    }
  }
}

TEST(GyroscopeCheckTest, NamesDegrees) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const GyroscopeVerdict verdict =
        Judge(Matrix3d::Identity() / kDegree, Vector3d(0.6, 0.3, 0.6), seed);
    EXPECT_THAT(verdict.words, HasSubstr("deg/s")) << seed;
    EXPECT_LT(verdict.after_s, 6) << seed;
  }
}

TEST(GyroscopeCheckTest, NamesSwappedAxes) {
  Matrix3d M;
  M << 0, 1, 0, 1, 0, 0, 0, 0, 1;
  int num_named = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const GyroscopeVerdict verdict = Judge(M, Vector3d(0.6, 0.6, 0.6), seed);
    EXPECT_THAT(verdict.words, Not(IsEmpty())) << seed;
    EXPECT_LT(verdict.after_s, 6) << seed;
    const bool is_named = verdict.words.find("(x were y, y were x, z were z)") != std::string::npos;
    num_named += is_named ? 1 : 0;
  }
  EXPECT_GE(num_named, 18) << "two axes that turn together leave other explanations";
}

TEST(GyroscopeCheckTest, NamesInvertedExtrinsics) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const GyroscopeVerdict verdict =
        Judge(Matrix3d::Identity(), Vector3d(0.6, 0.6, 0.6), seed, TrueMount().conjugate());
    EXPECT_THAT(verdict.words, HasSubstr("T_BS of cam0 were inverted")) << seed;
  }
}

TEST(GyroscopeCheckTest, NamesErrorsThatNobodyExpected) {
  const Quaterniond turned = TrueMount() * ExpSO3(Vector3d(0, 50 * kDegree, 0));
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_THAT(Judge(Matrix3d::Identity(), Vector3d(0.8, 0.8, 0.8), seed, turned).words,
                HasSubstr("the rotation of T_BS were off by"))
        << seed;
    EXPECT_THAT(Judge(4 * Matrix3d::Identity(), Vector3d(0.6, 0.6, 0.6), seed).words,
                HasSubstr("times the true rate"))
        << seed;
  }
}

TEST(GyroscopeCheckTest, ACameraThatRepeatsItselfIsNoReason) {
  GyroscopeCheck check(TrueMount());
  Turns turns(Vector3d(0.6, 0.6, 0.6), 1);
  for (int i = 0; i < 100; ++i) {
    SharedTurn turn = turns.Next(Matrix3d::Identity());
    turn.image.theta.setZero();
    EXPECT_THAT(check.Add(turn), IsEmpty());
  }
}

}  // namespace
}  // namespace facet
