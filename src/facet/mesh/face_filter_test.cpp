// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/face_filter.h"

#include <limits>

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

CameraFace Face(const Vector3d& a, const Vector3d& b, const Vector3d& c, double sigma_m = 0.01) {
  return {{a, b, c}, {sigma_m, sigma_m, sigma_m}};
}

FaceDefect Judge(const CameraFace& face, const FaceLimits& limits) {
  return FaceFilter(limits).Judge(face);
}

TEST(FaceFilter, AcceptsAFaceThatLooksAtTheCamera) {
  const CameraFace face = Face({-0.2, -0.2, 2}, {0.2, -0.2, 2}, {0, 0.2, 2});
  EXPECT_EQ(Judge(face, FaceLimits()), FaceDefect::kNone);
  EXPECT_EQ(Judge(face, StrictFaceLimits()), FaceDefect::kNone);
}

TEST(FaceFilter, NamesTheReason) {
  const FaceLimits limits;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Judge(Face({nan, 0, 2}, {1, 0, 2}, {0, 1, 2}), limits), FaceDefect::kNotFinite);
  EXPECT_EQ(Judge(Face({0, 0, 0.01}, {1, 0, 2}, {0, 1, 2}), limits), FaceDefect::kNotFinite);
  EXPECT_EQ(Judge(Face({0, 0, 2}, {.2, 0, 2}, {0, .2, 2}, 0.5), limits), FaceDefect::kUncertain);
  EXPECT_EQ(Judge(Face({0, 0, 2}, {2, 0, 2}, {0, 2, 2}), limits), FaceDefect::kTooLarge);
  EXPECT_EQ(Judge(Face({0, 0, 2}, {.4, 0, 2}, {.2, .01, 2}), limits), FaceDefect::kNarrow);
  EXPECT_EQ(Judge(Face({0, 0, 2}, {.2, 0, 2}, {0, .2, 2.8}), limits), FaceDefect::kElongated);
  FaceLimits flat = limits;
  flat.min_elongation = 0;
  EXPECT_EQ(Judge(Face({-.3, .1, 2}, {.3, .1, 2}, {0, .11, 2.4}), flat), FaceDefect::kGrazing);
}

TEST(FaceFilter, NoiseInDepthIsNotHeldAgainstAFace) {
  const Vector3d a(0, 0, 4), b(0.05, 0, 4.09), c(0, 0.05, 4);
  EXPECT_EQ(Judge(Face(a, b, c, 0.001), FaceLimits()), FaceDefect::kElongated);
  EXPECT_EQ(Judge(Face(a, b, c, 0.08), FaceLimits()), FaceDefect::kNone);
}

// But for elongation: steep faces vote, once their surroundings have proven them to be surface.
TEST(FaceFilter, WhatIsStrictlyAcceptedIsAccepted) {
  Rng rng(1);
  for (int trial = 0; trial < 20000; ++trial) {
    const Vector3d centre(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(0.5, 6));
    const CameraFace face = Face(centre + 0.2 * rng.Normal3(),
                                 centre + 0.2 * rng.Normal3(),
                                 centre + 0.2 * rng.Normal3(),
                                 rng.Uniform(0, 0.2));
    if (Judge(face, StrictFaceLimits()) != FaceDefect::kNone) continue;
    const FaceDefect defect = Judge(face, FaceLimits());
    EXPECT_TRUE(defect == FaceDefect::kNone || defect == FaceDefect::kElongated);
  }
}

TEST(FaceFilter, TheOrderOfTheCornersDoesNotMatter) {
  Rng rng(2);
  for (int trial = 0; trial < 5000; ++trial) {
    const Vector3d a(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(0.5, 6));
    const Vector3d b = a + 0.2 * rng.Normal3(), c = a + 0.2 * rng.Normal3();
    EXPECT_EQ(Judge(Face(a, b, c), FaceLimits()), Judge(Face(c, b, a), FaceLimits()));
  }
}

}  // namespace
}  // namespace facet
