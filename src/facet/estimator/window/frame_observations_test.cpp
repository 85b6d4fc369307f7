// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/frame_observations.h"

#include <limits>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

FeatureObservation Feature(std::int64_t id, double x, double y) {
  FeatureObservation feature;
  feature.landmark = LandmarkId{id};
  feature.px_left = Vector2d(x, y);
  feature.sigma_left_px = 0.5;
  feature.sigma_right_px = 0.8;
  return feature;
}

std::vector<PreparedObservation> Prepare(const std::vector<FeatureObservation>& features,
                                         double scale = 1.0) {
  FrameObservations frame;
  frame.features = features;
  return PrepareObservations(frame, testing::MakeTestRig(), scale);
}

TEST(FrameObservationsTest, PixelsBecomeWhitenedRays) {
  FeatureObservation feature = Feature(1, 400, 200);
  feature.px_right = Vector2d(380, 201);
  const auto prepared = Prepare({feature}, 3.0);
  ASSERT_EQ(prepared.size(), 1u);
  const WindowObservation& o = prepared[0].observation;
  const StereoRig rig = testing::MakeTestRig();
  EXPECT_TRUE(o.has_right);
  for (int c = 0; c < 2; ++c) {
    const Vector2d& px = c == 0 ? feature.px_left : *feature.px_right;
    const CameraModel& camera = rig.cameras[static_cast<std::size_t>(c)];
    const double sigma_px = 3.0 * (c == 0 ? 0.5 : 0.8);
    EXPECT_EQ(o.rays[c].bearing, camera.Unproject(px).value());
    EXPECT_EQ(o.sigma_px[c], sigma_px);
    // What is seen a hundredth of a pixel away is as many sigmas off.
    const Vector2d off_px(0.01, -0.02);
    const Vector2d error = o.rays[c].Error(camera.Unproject(px + off_px).value());
    EXPECT_LT((error * sigma_px - off_px).norm(), 1e-5);
    EXPECT_LT(o.rays[c].Error(5 * o.rays[c].bearing).norm(), 1e-12);
  }
}

TEST(FrameObservationsTest, WhatHeldLensesDoBesideTheirModelsIsTakenFromThePixels) {
  StereoRig rig = testing::MakeTestRig();
  rig.lens_modes[0].setConstant(0.1);
  rig.lens_modes[1].setConstant(-0.05);
  FeatureObservation feature = Feature(1, 400, 200);
  feature.px_right = Vector2d(380, 201);
  FrameObservations frame;
  frame.features = {feature};
  const LensFields fields = FieldsOf(rig);
  const auto prepared = PrepareObservations(frame, rig, 1.0, fields);
  ASSERT_EQ(prepared.size(), 1u);
  const WindowObservation& o = prepared[0].observation;
  for (int c = 0; c < 2; ++c) {
    const std::size_t i = static_cast<std::size_t>(c);
    const Vector2d& px = c == 0 ? feature.px_left : *feature.px_right;
    EXPECT_GT(fields[i].At(px).norm(), 0.01);
    EXPECT_EQ(o.px[c], px - fields[i].At(px));
    EXPECT_EQ(o.rays[c].bearing, rig.cameras[i].Unproject(o.px[c]).value());
  }
}

TEST(FrameObservationsTest, WhatHasNoUsablePixelOrSigmaIsPassedOver) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  FeatureObservation no_sigma = Feature(1, 400, 200), not_a_sigma = no_sigma;
  no_sigma.sigma_left_px = 0;
  not_a_sigma.sigma_left_px = kNan;
  FeatureObservation absurd = no_sigma, next_to_zero = no_sigma;
  absurd.sigma_left_px = 1e306;
  next_to_zero.sigma_left_px = 1e-310;
  EXPECT_TRUE(
      Prepare({no_sigma, not_a_sigma, absurd, next_to_zero, Feature(2, kNan, 100)}).empty());
  FeatureObservation left_only = Feature(3, 400, 200);
  left_only.px_right = Vector2d(380, 201);
  left_only.sigma_right_px = -1;
  const auto prepared = Prepare({left_only});
  ASSERT_EQ(prepared.size(), 1u);
  EXPECT_FALSE(prepared[0].observation.has_right);
}

TEST(FrameObservationsTest, NewLandmarksAreHostedInTheNewestFrameAndSeenOnceInIt) {
  SlidingWindow window;
  window.frames.resize(1);
  AppendObservations(Prepare({Feature(1, 400, 200)}), window);
  window.frames.resize(2);
  AppendObservations(Prepare({Feature(1, 410, 200), Feature(2, 100, 100), Feature(1, 500, 300)}),
                     window);
  ASSERT_EQ(window.landmarks().size(), 2u);
  const WindowLandmark& first = *window.Find(LandmarkId{1});
  const WindowLandmark& second = *window.Find(LandmarkId{2});
  EXPECT_EQ(first.host, 0);
  EXPECT_EQ(second.host, 1);
  EXPECT_FALSE(second.has_depth);
  ASSERT_EQ(first.observations.size(), 2u);
  EXPECT_EQ(first.observations[1].frame, 1);
  EXPECT_EQ(first.observations[1].px[0], Vector2d(410, 200));
}

}  // namespace
}  // namespace facet
