// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/face_filter.h"

#include <limits>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/mesh/far_surfaces.h"

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

// What votes for planes: as many pixels show larger sides there, and less exactly known ones.
TEST(FaceFilter, FarFacesMayBeLargerAndLessCertainToVote) {
  const FaceLimits strict = StrictFaceLimits();
  const auto judge = [&](double distance_m, double side_m, double sigma_m) {
    const double z = distance_m, s = side_m / 2;
    return Judge(Face({-s, -s, z}, {s, -s, z}, {0, s, z}, sigma_m), strict);
  };
  const double near_m = 0.8 * kFarDistance_m, far_m = 3 * kFarDistance_m;
  EXPECT_EQ(judge(near_m, 1.1 * strict.max_side_m, 0), FaceDefect::kTooLarge);
  EXPECT_EQ(judge(far_m, 2.5 * strict.max_side_m, 0), FaceDefect::kNone);
  EXPECT_EQ(judge(far_m, 3.3 * strict.max_side_m, 0), FaceDefect::kTooLarge);
  const auto certain = [&](double distance_m, double relative) {
    return judge(
        distance_m, 0.8 * strict.max_side_m, relative * strict.max_depth_sigma * distance_m);
  };
  EXPECT_EQ(certain(near_m, 1.1), FaceDefect::kUncertain);
  EXPECT_EQ(certain(far_m, 2.8), FaceDefect::kNone);
  EXPECT_EQ(certain(far_m, 3.3), FaceDefect::kUncertain);
}

TEST(FaceFilter, FacesOfTheMeshAreJudgedAlikeAtEveryDistance) {
  const FaceLimits limits;
  const double z = 3 * kFarDistance_m, s = 0.6 * limits.max_side_m;
  EXPECT_EQ(Judge(Face({-s, -s, z}, {s, -s, z}, {0, s, z}), limits), FaceDefect::kTooLarge);
  const double sigma_m = 1.1 * limits.max_depth_sigma * z;
  EXPECT_EQ(Judge(Face({0, 0, z}, {1, 0, z}, {0, 1, z}, sigma_m), limits), FaceDefect::kUncertain);
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
