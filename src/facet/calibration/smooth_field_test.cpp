// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/smooth_field.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

constexpr int kImageWidth = 752, kImageHeight = 480;

TEST(SmoothFieldTest, HasTheSizeThatWasAskedFor) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Rng rng(seed);
    const SmoothField field = SmoothField::Draw(kImageWidth, kImageHeight, 0.15, rng);
    double squares = 0;
    int count = 0;
    for (double y = 0.5; y < 100; ++y) {
      for (double x = 0.5; x < 100; ++x, count += 2)
        squares +=
            field.At({(kImageWidth - 1) * x / 100, (kImageHeight - 1) * y / 100}).squaredNorm();
    }
    EXPECT_NEAR(std::sqrt(squares / count), 0.15, 1e-4);
  }
}

TEST(SmoothFieldTest, CovarianceIsThatOfDrawnFields) {
  Rng rng(1);
  constexpr int kDraws = 20000;
  const std::array<Vector2d, 3> pixels = {Vector2d(375, 240), Vector2d(20, 30), Vector2d(700, 200)};
  Matrix3d sampled = Matrix3d::Zero();
  double cross = 0;
  for (int i = 0; i < kDraws; ++i) {
    const SmoothField field = SmoothField::Draw(kImageWidth, kImageHeight, 1, rng);
    const Vector3d x(field.At(pixels[0]).x(), field.At(pixels[1]).x(), field.At(pixels[2]).x());
    sampled += x * x.transpose() / kDraws;
    cross += x(1) * field.At(pixels[1]).y() / kDraws;
  }
  Matrix<3, kNumMonomials> monomials;
  for (int i = 0; i < 3; ++i)
    monomials.row(i) =
        SmoothField::Monomials(pixels[static_cast<std::size_t>(i)], kImageWidth, kImageHeight);
  const Matrix3d stated = monomials * SmoothField::Covariance() * monomials.transpose();
  EXPECT_LT((sampled - stated).cwiseAbs().maxCoeff(), 0.03 * stated.maxCoeff());
  EXPECT_NEAR(cross, 0, 0.03 * stated.maxCoeff());
}

}  // namespace
}  // namespace facet
