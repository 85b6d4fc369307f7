// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/surface_unevenness.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

// Landmarks of a surface as uneven as that, which vision sees with the given 1-sigma.
double Estimate(double unevenness_m, double vision_m) {
  Rng rng(3);
  SurfaceUnevenness unevenness;
  for (int keyframe = 0; keyframe < 40; ++keyframe) {
    double excess = 0, weight = 0;
    for (int i = 0; i < 50; ++i) {
      const double r = unevenness_m * rng.Normal() + vision_m * rng.Normal();
      excess += r * r - vision_m * vision_m;
      weight += 1;
    }
    unevenness.Add(excess, weight);
  }
  return unevenness.sigma_m();
}

TEST(SurfaceUnevennessTest, IsWhatVisionDoesNotExplain) {
  EXPECT_NEAR(Estimate(0.02, 0.01), 0.02, 0.001);
  EXPECT_NEAR(Estimate(0.008, 0.01), 0.008, 0.001);
  EXPECT_LT(Estimate(0, 0.01), 0.002);
}

TEST(SurfaceUnevennessTest, NothingIsKnownAtFirst) {
  EXPECT_EQ(SurfaceUnevenness().sigma_m(), 0);
}

TEST(SurfaceUnevennessTest, WhatIsSeenNowCountsMore) {
  SurfaceUnevenness unevenness;
  for (int i = 0; i < 100; ++i)
    unevenness.Add(10 * 1e-4, 10);
  EXPECT_NEAR(unevenness.sigma_m(), 0.01, 1e-9);
  for (int i = 0; i < 100; ++i)
    unevenness.Add(-10 * 1e-5, 10);
  EXPECT_EQ(unevenness.sigma_m(), 0);
}

}  // namespace
}  // namespace facet
