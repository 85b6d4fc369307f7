// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/quaternion_order.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

/// A body that turns by up to `turn` rad about all axes, estimated with errors of up to `error` rad
/// in a world of its own.
std::vector<PosePair> Turning(double turn, double error) {
  Rng rng(1);
  const Quaterniond q_GW = ExpSO3({0.3, -0.2, 2.0});
  std::vector<PosePair> pairs;
  for (int i = 0; i < 200; ++i) {
    const double a = 0.05 * i;
    PosePair pair;
    pair.t = {50'000'000LL * i};
    pair.T_GB.q =
        ExpSO3(turn * Vector3d(std::sin(0.7 * a), 0.5 * std::cos(1.1 * a), std::sin(0.4 * a)));
    pair.T_WB.q = q_GW.conjugate() * pair.T_GB.q * ExpSO3(error * rng.Normal3());
    pairs.push_back(pair);
  }
  return pairs;
}

/// w x y z, taken for x y z w.
Quaterniond TumMisread(const Quaterniond& q) {
  return {q.z(), q.w(), q.x(), q.y()};
}

/// x y z w, taken for w x y z.
Quaterniond EurocMisread(const Quaterniond& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}

TEST(QuaternionOrderTest, RightOrderIsFine) {
  for (double error : {0.0, 0.02, 0.1})
    EXPECT_FALSE(FindSwappedQuaternions(Turning(1.5, error))) << error;
}

TEST(QuaternionOrderTest, WrongOrderIsFoundOnBothSidesAndInBothFormats) {
  for (const auto& misread : {TumMisread, EurocMisread}) {
    for (const bool is_truth : {false, true}) {
      std::vector<PosePair> pairs = Turning(1.5, 0.01);
      for (PosePair& pair : pairs) {
        Quaterniond& q = is_truth ? pair.T_GB.q : pair.T_WB.q;
        q = misread(q);
      }
      const auto found = FindSwappedQuaternions(pairs);
      ASSERT_TRUE(found);
      EXPECT_GT(found->as_read_deg, 30);
      EXPECT_LT(found->reordered_deg, 3);
    }
  }
}

TEST(QuaternionOrderTest, NonsenseThatNoOrderExplainsIsNotThat) {
  EXPECT_FALSE(FindSwappedQuaternions(Turning(1.5, 1.0)));
}

TEST(QuaternionOrderTest, NothingTurns) {
  std::vector<PosePair> pairs = Turning(0.02, 0.001);
  for (PosePair& pair : pairs)
    pair.T_WB.q = TumMisread(pair.T_WB.q);
  EXPECT_FALSE(FindSwappedQuaternions(pairs));
  EXPECT_FALSE(FindSwappedQuaternions({}));
}

}  // namespace
}  // namespace facet
