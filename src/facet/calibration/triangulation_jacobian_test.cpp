// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/triangulation_jacobian.h"

#include <gtest/gtest.h>

#include "facet/camera/stereo_triangulation.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

TEST(TriangulationJacobianTest, IsTheDerivativeByEveryParameter) {
  const StereoRig rig = EurocRig();
  for (const Vector3d& p_C0 :
       {Vector3d(0.2, -0.3, 1.5), Vector3d(-1, 0.6, 4), Vector3d(0, 0, 0.7), Vector3d(2, -1, 9)}) {
    const Vector2d left_px = *rig.cameras[0].Project(p_C0);
    const Vector2d right_px = *rig.cameras[1].Project(rig.T_C1C0() * p_C0);
    const auto J = TriangulationJacobian(rig, p_C0);
    ASSERT_TRUE(J);
    const auto triangulate = [&](const RigVector& delta) {
      const StereoRig changed = *ChangeParameters(rig, delta);
      const Vector3d bearing = *changed.cameras[0].Unproject(left_px);
      const auto found =
          TriangulateOnRay(bearing, *changed.cameras[1].BearingOf(right_px), changed.T_C1C0());
      return Vector3d(bearing / found->inverse_distance);
    };
    testing::ExpectJacobian<3, kNumRigParameters>(*J, triangulate, 1e-4, 1e-6);
  }
}

TEST(TriangulationJacobianTest, WhatNoCameraSeesHasNone) {
  EXPECT_FALSE(TriangulationJacobian(EurocRig(), Vector3d(0, 0, -1)));
}

}  // namespace
}  // namespace facet
