// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/smooth_field.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "facet/base/check.h"

namespace facet {
namespace {

using MomentMatrix = Matrix<kNumMonomials, kNumMonomials>;

struct Powers {
  int x, y;
};
constexpr std::array<Powers, kNumMonomials> kPowers = {
    {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}, {3, 0}, {2, 1}, {1, 2}, {0, 3}}};

/// Mean of x^n for x from -1 to 1.
double MeanPower(int n) {
  return n % 2 == 0 ? 1.0 / (n + 1) : 0;
}

}  // namespace

int MonomialIndex(int i, int j) {
  const auto* const place = std::find_if(
      kPowers.begin(), kPowers.end(), [&](const Powers& p) { return p.x == i && p.y == j; });
  FACET_CHECK(place != kPowers.end()) << i << " and " << j;
  return static_cast<int>(place - kPowers.begin());
}

MomentMatrix SmoothField::Moments() {
  MomentMatrix M;
  for (std::size_t i = 0; i < kNumMonomials; ++i) {
    for (std::size_t j = 0; j < kNumMonomials; ++j) {
      M(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          MeanPower(kPowers[i].x + kPowers[j].x) * MeanPower(kPowers[i].y + kPowers[j].y);
    }
  }
  return M;
}

Vector<kNumMonomials> SmoothField::Monomials(const Vector2d& px, int width, int height) {
  const double x = 2 * px.x() / (width - 1) - 1, y = 2 * px.y() / (height - 1) - 1;
  Vector<kNumMonomials> m;
  m << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
  return m;
}

SmoothField SmoothField::Draw(int width, int height, double rms_px, Rng& rng) {
  Matrix<kNumMonomials, 2> c;
  for (int axis = 0; axis < 2; ++axis) {
    for (int i = 0; i < kNumMonomials; ++i)
      c(i, axis) = rng.Normal();
  }
  const double mean_square = 0.5 * (c.transpose() * Moments() * c).trace();
  return SmoothField(width, height, rms_px / std::sqrt(mean_square) * c);
}

Matrix<kNumMonomials, kNumMonomials> SmoothField::Covariance() {
  // A drawn axis is c / sqrt(q), with the mean square q = (c'Mc + d'Md) / 2 of both axes. With
  // 1 / q = int exp(-t q) dt the expectation of c c' / q is an integral over t, which M's
  // eigenvectors make diagonal. In log t the trapezoidal rule is exact to all digits.
  const Eigen::SelfAdjointEigenSolver<MomentMatrix> solver(Moments());
  const Vector<kNumMonomials> lambda = solver.eigenvalues();
  Vector<kNumMonomials> variance = Vector<kNumMonomials>::Zero();
  constexpr double kStep = 0.05;
  for (double u = -40; u < 60; u += kStep) {
    const double t = std::exp(u);
    const Vector<kNumMonomials> shrunk = (1 + t * lambda.array()).inverse();
    variance += kStep * t * shrunk.prod() * shrunk;
  }
  return solver.eigenvectors() * variance.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace facet
