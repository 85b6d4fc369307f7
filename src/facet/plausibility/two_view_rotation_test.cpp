// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/two_view_rotation.h"

#include <vector>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/se3.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr double kSigma = 0.7 / 458;

// What a camera of 80 x 55 deg sees at 1.5 to 6 m before and after a motion.
std::vector<BearingPair> Pairs(const SE3& T_first_second, int num, double wrong_share, Rng& rng) {
  std::vector<BearingPair> pairs;
  for (int i = 0; i < num; ++i) {
    const double z = rng.Uniform(1.5, 6);
    const Vector3d p_first(z * rng.Uniform(-0.8, 0.8), z * rng.Uniform(-0.5, 0.5), z);
    const auto noisy = [&](const Vector3d& p) {
      return (p.normalized() + kSigma * Vector3d(rng.Normal(), rng.Normal(), 0)).normalized();
    };
    BearingPair pair{noisy(p_first), noisy(T_first_second.Inverse() * p_first)};
    if (rng.Uniform() < wrong_share) {
      pair.second = Vector3d(rng.Uniform(-0.8, 0.8), rng.Uniform(-0.5, 0.5), 1).normalized();
    }
    pairs.push_back(pair);
  }
  return pairs;
}

TEST(TwoViewRotationTest, FindsTheRotationWithinItsCovariance) {
  Rng rng(1);
  double sum = 0;
  constexpr int kNum = 200;
  for (int i = 0; i < kNum; ++i) {
    const Vector3d theta = 0.1 * rng.Normal3(), t = 0.1 * rng.Normal3();
    const auto found = EstimateTwoViewRotation(Pairs(SE3(ExpSO3(theta), t), 60, 0, rng), kSigma);
    ASSERT_TRUE(found);
    const Vector3d error = LogSO3(ExpSO3(theta).conjugate() * ExpSO3(found->theta));
    EXPECT_LT(error.norm(), 0.02) << i;
    sum += error.dot(found->covariance.inverse() * error);
  }
  EXPECT_LT(sum / kNum, 6) << "3 if the covariance is right";
}

TEST(TwoViewRotationTest, NoTranslationIsNoTrouble) {
  Rng rng(2);
  for (int i = 0; i < 50; ++i) {
    const Vector3d theta = 0.1 * rng.Normal3();
    const auto found =
        EstimateTwoViewRotation(Pairs(SE3(ExpSO3(theta), Vector3d::Zero()), 60, 0, rng), kSigma);
    ASSERT_TRUE(found);
    EXPECT_LT((found->theta - theta).norm(), 0.02) << i;
  }
}

TEST(TwoViewRotationTest, AThirdOfThePairsMayBeWrong) {
  Rng rng(3);
  for (int i = 0; i < 50; ++i) {
    const Vector3d theta = 0.05 * rng.Normal3();
    const auto pairs = Pairs(SE3(ExpSO3(theta), Vector3d(0.1, 0, 0.05)), 60, 0.33, rng);
    const auto found = EstimateTwoViewRotation(pairs, kSigma);
    ASSERT_TRUE(found);
    EXPECT_LT((found->theta - theta).norm(), 0.05) << i;
  }
}

TEST(TwoViewRotationTest, FewPairsAreNone) {
  Rng rng(4);
  EXPECT_FALSE(EstimateTwoViewRotation(Pairs(SE3(), 19, 0, rng), kSigma));
}

}  // namespace
}  // namespace facet
