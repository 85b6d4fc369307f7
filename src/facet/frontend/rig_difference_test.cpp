// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/rig_difference.h"

#include <gtest/gtest.h>

#include "facet/frontend/stereo_turn.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

StereoRig WithCentreMoved(StereoRig rig, std::size_t camera, double x_px, double y_px) {
  CameraIntrinsics k = rig.cameras[camera].intrinsics();
  k.cx += x_px;
  k.cy += y_px;
  rig.cameras[camera] = CameraModel(k);
  return rig;
}

StereoRig WithBaselineTimes(StereoRig rig, double factor) {
  SE3 T_C1C0 = rig.T_C1C0();
  T_C1C0.p *= factor;
  rig.T_BC[1] = rig.T_BC[0] * T_C1C0.Inverse();
  return rig;
}

TEST(RigDifferenceTest, WhatACarefulCalibrationLeavesIsSeenTheSame) {
  const StereoRig rig = EurocRig();
  EXPECT_FALSE(SeesDifferently(rig, rig));
  EXPECT_FALSE(SeesDifferently(rig, WithCentreMoved(rig, 0, 0.2, -0.2)));
  EXPECT_FALSE(SeesDifferently(rig, TurnedRig(rig, Vector3d(0.01, 0.02, 0.02) * kDegree)));
  EXPECT_FALSE(SeesDifferently(rig, WithBaselineTimes(rig, 1.001)));
}

TEST(RigDifferenceTest, ErrorsOfThePairAreSeen) {
  const StereoRig rig = EurocRig();
  EXPECT_TRUE(SeesDifferently(rig, WithCentreMoved(rig, 0, 1.5, 0))) << "disparities";
  EXPECT_TRUE(SeesDifferently(rig, WithCentreMoved(rig, 1, 0, -1.5))) << "across the lines";
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_TRUE(SeesDifferently(rig, TurnedRig(rig, 0.3 * kDegree * Vector3d::Unit(axis)))) << axis;
  EXPECT_TRUE(SeesDifferently(rig, WithBaselineTimes(rig, 1.03))) << "near points";
}

TEST(RigDifferenceTest, WhatBothCamerasShareIsSeenInTheLeftOne) {
  const StereoRig rig = EurocRig();
  const StereoRig both = WithCentreMoved(WithCentreMoved(rig, 0, 6, 0), 1, 6, 0);
  EXPECT_TRUE(SeesDifferently(rig, both));
  EXPECT_TRUE(SeesDifferently(both, rig));
}

// Where the cameras are on the body moves no point in their images.
TEST(RigDifferenceTest, TheMountIsNotSeen) {
  const StereoRig rig = EurocRig();
  StereoRig turned = rig;
  const SE3 mount(ExpSO3(Vector3d(0.02, -0.01, 0.03)), Vector3d(0.02, 0, 0.01));
  for (SE3& T_BC : turned.T_BC)
    T_BC = mount * T_BC;
  EXPECT_FALSE(SeesDifferently(rig, turned));
}

}  // namespace
}  // namespace facet
