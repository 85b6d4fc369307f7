// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/landmark_depth.h"

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

// Views of one point from frames 1 m apart at most, in a row along x.
struct Scene {
  StereoRig rig = testing::MakeTestRig();
  std::vector<WindowFrame> frames;
  WindowLandmark landmark;

  Scene(const Vector3d& p_C,
        const std::vector<double>& positions,
        bool stereo,
        double noise_px = 0) {
    Rng rng(1);
    const Vector3d p_W = rig.T_BC[0] * p_C;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      WindowFrame frame;
      frame.x.T_WB.p = rig.T_BC[0].q * Vector3d(positions[i], 0, 0);
      frames.push_back(frame);
      WindowObservation o;
      o.frame = static_cast<int>(i);
      o.has_right = stereo;
      for (int c = 0; c < 2; ++c) {
        testing::SetMeasurement((frame.x.T_WB * rig.T_BC[c]).Inverse() * p_W, c, 1.0, o);
        const double x = rng.Normal(), y = rng.Normal();
        testing::ShiftMeasurement(noise_px / 450 * Vector2d(x, y), c, o);
      }
      landmark.observations.push_back(o);
    }
  }

  bool Initialize() {
    FrameGeometry geometry(rig);
    geometry.Update(frames);
    return InitializeDepth(geometry, landmark);
  }
};

TEST(LandmarkDepthTest, OneStereoPairIsEnough) {
  for (const double depth : {0.5, 3.0, 20.0}) {
    const Vector3d p_C = depth * Vector3d(0.2, -0.3, 1);
    Scene scene(p_C, {0.0}, true);
    ASSERT_TRUE(scene.Initialize());
    EXPECT_TRUE(scene.landmark.has_depth);
    EXPECT_NEAR(scene.landmark.inverse_distance, 1 / p_C.norm(), 1e-9);
    EXPECT_LT((scene.landmark.bearing_H - p_C.normalized()).norm(), 1e-12);
  }
}

TEST(LandmarkDepthTest, SeveralMonocularViewsAreEnoughWithParallax) {
  const Vector3d p_C(0.5, -0.2, 4);
  Scene scene(p_C, {0, 0.2, 0.5, 0.9}, false, 0.3);
  ASSERT_TRUE(scene.Initialize());
  EXPECT_NEAR(scene.landmark.inverse_distance, 1 / p_C.norm(), 0.01);
}

TEST(LandmarkDepthTest, WithoutParallaxTheDistanceStaysUnknown) {
  Scene same_place(Vector3d(0.5, -0.2, 4), {0, 0, 0}, false, 0.3);
  EXPECT_FALSE(same_place.Initialize());
  EXPECT_FALSE(same_place.landmark.has_depth);
  Scene too_far(Vector3d(5, -2, 40), {0, 0.02, 0.04}, false, 0.3);
  EXPECT_FALSE(too_far.Initialize());
  Scene single_view(Vector3d(0.5, -0.2, 4), {0}, false);
  EXPECT_FALSE(single_view.Initialize());
}

TEST(LandmarkDepthTest, AFarPointIsAtInfinityNotBehind) {
  Scene scene(1e9 * Vector3d(0.1, 0.1, 1), {0}, true);
  ASSERT_TRUE(scene.Initialize());
  EXPECT_NEAR(scene.landmark.inverse_distance, 0, 1e-8);
  // A disparity that is negative by noise.
  testing::ShiftMeasurement({0.01, 0}, 1, scene.landmark.observations[0]);
  ASSERT_TRUE(scene.Initialize());
  EXPECT_EQ(scene.landmark.inverse_distance, 0);
}

TEST(LandmarkDepthTest, TheHostMayBeAnyFrame) {
  const Vector3d p_C(0.5, -0.2, 4);
  Scene scene(p_C, {0, 0.2, 0.5}, true);
  scene.landmark.host = 2;
  ASSERT_TRUE(scene.Initialize());
  EXPECT_NEAR(scene.landmark.inverse_distance, 1 / (p_C - Vector3d(0.5, 0, 0)).norm(), 1e-9);
}

}  // namespace
}  // namespace facet
