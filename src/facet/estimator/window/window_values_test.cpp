// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/window_values.h"

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

TEST(WindowValuesTest, ValuesComeBackAndMembershipsStay) {
  Rng rng(4);
  SlidingWindow window = testing::MakeTestWindow({}, rng).window;
  window.planes.emplace_back(
      PlaneId{7}, Plane{Vector3d::UnitZ(), 1.5}, Vector3d(1, 2, 1.5), testing::kPlaneSigma_m);
  window.frames[1].pose_frozen = true;
  const SlidingWindow before = window;
  WindowValues values;
  values.Save(window);

  for (WindowFrame& frame : window.frames)
    frame.ApplyStep(Vector<15>::Constant(0.02));
  window.planes[0].ApplyStep(Vector3d(0.1, -0.2, 0.3));
  WindowLandmark& landmark = window.landmarks()[3];
  landmark.inverse_distance *= 2;
  landmark.bearing_H = Vector3d::UnitX();
  landmark.planes.Add(0);
  ASSERT_GT((window.frames[0].x.T_WB.p - before.frames[0].x.T_WB.p).norm(), 0.01);

  values.Restore(window);
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    EXPECT_EQ(window.frames[i].x.T_WB.p, before.frames[i].x.T_WB.p);
    EXPECT_EQ(window.frames[i].x.T_WB.q.coeffs(), before.frames[i].x.T_WB.q.coeffs());
    EXPECT_EQ(window.frames[i].x.v_WB, before.frames[i].x.v_WB);
    EXPECT_EQ(window.frames[i].delta, before.frames[i].delta);
  }
  EXPECT_EQ(window.planes[0].n, before.planes[0].n);
  EXPECT_EQ(window.planes[0].offset, before.planes[0].offset);
  EXPECT_EQ(landmark.inverse_distance, before.landmarks()[3].inverse_distance);
  EXPECT_EQ(landmark.bearing_H, before.landmarks()[3].bearing_H);
  EXPECT_TRUE(landmark.planes.Contains(0));
}

}  // namespace
}  // namespace facet
