// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/intrinsics_jacobian.h"

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/lens_examples.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

StereoRig RigWith(const CameraIntrinsics& lens) {
  StereoRig rig = EurocRig();
  rig.cameras.fill(CameraModel(lens));
  return rig;
}

class IntrinsicsJacobianTest : public ::testing::TestWithParam<CameraIntrinsics> {};

INSTANTIATE_TEST_SUITE_P(Models,
                         IntrinsicsJacobianTest,
                         ::testing::ValuesIn(testing::LensExamples()));

TEST_P(IntrinsicsJacobianTest, IsTheDerivativeByEveryParameter) {
  const StereoRig rig = RigWith(GetParam());
  for (const Vector3d& p_C :
       {Vector3d(0.4, -0.3, 1.2), Vector3d(-0.6, 0.2, 1), Vector3d(0, 0, 2)}) {
    const auto d = ProjectWithDerivatives(rig.cameras[0], p_C);
    ASSERT_TRUE(d);
    EXPECT_EQ(d->px, *rig.cameras[0].Project(p_C));
    const auto project = [&](const Vector<kNumIntrinsics>& delta) {
      RigVector all = RigVector::Zero();
      all.head<kNumIntrinsics>() = delta;
      return *ChangeParameters(rig, all)->cameras[0].Project(p_C);
    };
    testing::ExpectJacobian<2, kNumIntrinsics>(d->J_px_k, project, 1e-6);
    IntrinsicsVector change;
    change << 1, -2, 3, 0.5, 0.01, -0.02, 0.03, -0.04;
    const CameraIntrinsics& k = rig.cameras[0].intrinsics();
    EXPECT_LT((ShiftByIntrinsics(k, 3 * p_C, d->px, change) - d->J_px_k * change).norm(), 1e-9);
    const auto move = [&](const Vector3d& dp) { return *rig.cameras[0].Project(p_C + dp); };
    testing::ExpectJacobian<2, 3>(d->J_px_p, move, 1e-6);
  }
}

TEST(RigParametersTest, DifferenceUndoesChange) {
  const StereoRig rig = EurocRig();
  RigVector delta;
  for (int i = 0; i < kNumRigParameters; ++i)
    delta(i) = 1e-3 * (i + 1);
  const auto changed = ChangeParameters(rig, delta);
  ASSERT_TRUE(changed);
  EXPECT_LT((ParameterDifference(rig, *changed) - delta).norm(), 1e-12);
  EXPECT_EQ(changed->T_BC[0].p, rig.T_BC[0].p);
  EXPECT_EQ(changed->T_BC[0].q.coeffs(), rig.T_BC[0].q.coeffs());
}

TEST(RigParametersTest, UnusableCamerasAreRefused) {
  RigVector delta = RigVector::Zero();
  delta(kNumIntrinsics) = -1000;
  EXPECT_FALSE(ChangeParameters(EurocRig(), delta));
}

}  // namespace
}  // namespace facet
