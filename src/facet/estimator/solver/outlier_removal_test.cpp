// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/outlier_removal.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

constexpr double kMaxSigma = 5;

/// Perfect measurements; the first landmark with at least three observations, one of them stereo,
/// is there to be damaged.
class OutlierRemovalTest : public ::testing::Test {
 protected:
  OutlierRemovalTest() : test_(Make()) {
    for (WindowLandmark& landmark : window().landmarks()) {
      if (landmark.observations.size() < 3 || !landmark.observations.back().has_right) continue;
      victim_ = landmark.id;
      break;
    }
  }
  static testing::TestWindow Make() {
    Rng rng(11);
    testing::TestWindowOptions options;
    options.noise = 0;
    return MakeTestWindow(options, rng);
  }

  SlidingWindow& window() { return test_.window; }
  WindowLandmark& victim() { return *window().Find(victim_); }
  int Remove() {
    FrameGeometry geometry(test_.rig);
    geometry.Update(window().frames);
    const OutlierRemoval removal =
        OutlierRemover().Remove(geometry, testing::NoiseOfWidth(2.0), kMaxSigma, window());
    median_sigma_ = removal.median_sigma;
    return removal.num_removed;
  }

  testing::TestWindow test_;
  LandmarkId victim_;
  std::optional<double> median_sigma_;
};

TEST_F(OutlierRemovalTest, WhatFitsStays) {
  const std::size_t num_landmarks = window().landmarks().size();
  const std::size_t num_observations = victim().observations.size();
  EXPECT_EQ(Remove(), 0);
  EXPECT_EQ(window().landmarks().size(), num_landmarks);
  EXPECT_EQ(victim().observations.size(), num_observations);
}

TEST_F(OutlierRemovalTest, AWrongMatchToTheRightGoesAlone) {
  const std::size_t num_observations = victim().observations.size();
  testing::ShiftMeasurement({0.05, 0}, 1, victim().observations.back());
  EXPECT_EQ(Remove(), 1);
  EXPECT_FALSE(victim().observations.back().has_right);
  EXPECT_EQ(victim().observations.size(), num_observations);
}

TEST_F(OutlierRemovalTest, AWrongMeasurementGoes) {
  const int frame = victim().observations.back().frame;
  testing::ShiftMeasurement({0, 0.05}, 0, victim().observations.back());
  EXPECT_GE(Remove(), 1);
  EXPECT_TRUE(std::none_of(victim().observations.begin(),
                           victim().observations.end(),
                           [&](const WindowObservation& o) { return o.frame == frame; }));
}

TEST_F(OutlierRemovalTest, ALandmarkThatLosesItsHostGetsAnotherAndStaysInPlace) {
  const Vector3d p_W = window().PositionOf(victim());
  WindowObservation& first = victim().observations.front();
  ASSERT_EQ(first.frame, victim().host);
  testing::ShiftMeasurement({0, 0.05}, 0, first);
  EXPECT_GE(Remove(), 1);
  EXPECT_EQ(victim().host, victim().observations.front().frame);
  EXPECT_LT((window().PositionOf(victim()) - p_W).norm(), 1e-6);
}

TEST_F(OutlierRemovalTest, LandmarksWithoutAnyObservationLeftGo) {
  for (WindowObservation& o : victim().observations)
    testing::ShiftMeasurement({0, o.frame % 2 == 0 ? 0.2 : -0.2}, 0, o);
  EXPECT_GE(Remove(), 3);
  EXPECT_EQ(window().Find(victim_), nullptr);
}

TEST_F(OutlierRemovalTest, TheMedianHardlyNoticesTheOutliers) {
  for (WindowLandmark& landmark : window().landmarks()) {
    for (WindowObservation& o : landmark.observations)
      testing::ShiftMeasurement(testing::OneSigmaOnPlane(o.rays[0]) * Vector2d(0.3, 0.4), 0, o);
  }
  Remove();
  ASSERT_TRUE(median_sigma_);
  EXPECT_NEAR(*median_sigma_, 0.5, 1e-4);
  for (std::size_t l = 0; l < window().landmarks().size(); l += 10)
    testing::ShiftMeasurement({0.05, 0}, 0, window().landmarks()[l].observations.back());
  EXPECT_GE(Remove(), 1);
  EXPECT_NEAR(*median_sigma_, 0.5, 1e-4);
}

TEST_F(OutlierRemovalTest, WithoutLandmarksThereIsNoMedian) {
  window().RemoveLandmarks(std::vector<char>(window().landmarks().size(), 1));
  EXPECT_EQ(Remove(), 0);
  EXPECT_FALSE(median_sigma_);
}

TEST_F(OutlierRemovalTest, LandmarksBeforeTheLensGo) {
  victim().inverse_distance = 20;
  Remove();
  EXPECT_EQ(window().Find(victim_), nullptr);
}

}  // namespace
}  // namespace facet
