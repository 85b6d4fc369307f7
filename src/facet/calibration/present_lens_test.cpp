// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/present_lens.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

CameraModel CameraWith(DistortionModel distortion) {
  CameraIntrinsics k;
  k.width = 752;
  k.height = 480;
  k.fx = 458;
  k.fy = 457;
  k.cx = 367;
  k.cy = 248;
  k.distortion = distortion;
  k.coefficients = {-0.28, 0.07, 2e-4, -3e-4};
  return CameraModel(k);
}

/// Changes as careful calibrations have them, and a field of 0.13 px.
class PresentLensTest : public ::testing::TestWithParam<DistortionModel> {
 protected:
  PresentLensTest() {
    Rng rng(7);
    for (int i = 0; i < kNumIntrinsics; ++i)
      change_(i) = (i < 4 ? 0.3 : 3e-4) * rng.Normal();
    field_ = SmoothField::Draw(752, 480, 0.13, rng);
  }

  const CameraModel camera_ = CameraWith(GetParam());
  IntrinsicsVector change_;
  SmoothField field_;
};

INSTANTIATE_TEST_SUITE_P(Lenses,
                         PresentLensTest,
                         ::testing::Values(DistortionModel::kNone,
                                           DistortionModel::kRadialTangential,
                                           DistortionModel::kRational,
                                           DistortionModel::kEquidistant));

TEST_P(PresentLensTest, AddsFirstOrderChangesToTheModel) {
  const PresentLens present(camera_, change_, field_);
  for (const Vector3d& p_C : {Vector3d(0.1, 0.2, 3), Vector3d(-1.4, 0.8, 2), Vector3d(0, 0, 1)}) {
    const auto nominal = ProjectWithDerivatives(camera_, p_C);
    ASSERT_TRUE(nominal);
    const Vector2d expected = nominal->px + nominal->J_px_k * change_ + field_.At(nominal->px);
    const auto px = present.Project(p_C);
    ASSERT_TRUE(px);
    // The field is taken where the changed model has the point.
    EXPECT_LT((*px - expected).norm(), 0.01 * (nominal->J_px_k * change_).norm());
    EXPECT_LT((nominal->px + present.Shift(p_C, nominal->px) - expected).norm(), 1e-10);
  }
}

TEST_P(PresentLensTest, WithoutChangesItIsTheModel) {
  const PresentLens present(camera_, IntrinsicsVector::Zero(), SmoothField());
  for (const Vector3d& p_C : {Vector3d(0.1, 0.2, 3), Vector3d(-1.4, 0.8, 2)})
    EXPECT_LT((*present.Project(p_C) - *camera_.Project(p_C)).norm(), 1e-10);
}

TEST_P(PresentLensTest, SeesWhatTheModelSees) {
  const PresentLens present(camera_, change_, field_);
  for (double x = -30; x <= 30; x += 0.1) {
    for (const double z : {-1.0, 0.0, 1.0}) {
      const Vector3d p_C(x, 0.3 * x, z);
      EXPECT_EQ(present.Project(p_C).has_value(), camera_.Project(p_C).has_value())
          << p_C.transpose();
    }
  }
}

}  // namespace
}  // namespace facet
