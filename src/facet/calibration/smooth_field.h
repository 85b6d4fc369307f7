// SPDX-License-Identifier: BSD-2-Clause
// A smooth displacement of pixels: polynomials of third order over the image, as what a lens does
// that a few coefficients of distortion cannot say.
#pragma once

#include "facet/base/random.h"
#include "facet/base/types.h"

namespace facet {

/// Monomials x^i y^j with i + j <= 3: 1, x, y, xx, xy, yy, xxx, xxy, xyy, yyy.
inline constexpr int kNumMonomials = 10;

/// The place of x^i y^j among them.
int MonomialIndex(int i, int j);

class SmoothField {
 public:
  /// None.
  SmoothField() = default;
  /// Columns: of the monomials in the displacement along x and along y [px].
  SmoothField(int width, int height, const Matrix<kNumMonomials, 2>& coefficients)
      : scale_(2.0 / (width - 1), 2.0 / (height - 1)), coefficients_(coefficients.transpose()) {}

  /// The monomials at a pixel, with x and y from -1 to 1 over the image.
  static Vector<kNumMonomials> Monomials(const Vector2d& px, int width, int height);

  /// Means over the image of the products of two monomials.
  static Matrix<kNumMonomials, kNumMonomials> Moments();

  /// Coefficients of both axes from N(0, 1), scaled so that the root mean square over the image and
  /// both axes is `rms_px`.
  static SmoothField Draw(int width, int height, double rms_px, Rng& rng);

  /// Covariance of one axis' coefficients over all drawn fields of 1 px rms. Coefficients of
  /// different axes are not correlated.
  static Matrix<kNumMonomials, kNumMonomials> Covariance();

  /// The displacement at a pixel [px].
  Vector2d At(const Vector2d& px) const {
    const double x = scale_.x() * px.x() - 1, y = scale_.y() * px.y() - 1;
    const auto of = [this](int monomial) { return coefficients_.col(monomial); };
    const Vector2d by_x = of(1) + x * (of(3) + x * of(6) + y * of(7)) + y * (of(4) + y * of(8));
    const Vector2d by_y = of(2) + y * (of(5) + y * of(9));
    return of(0) + x * by_x + y * by_y;
  }

 private:
  Vector2d scale_ = Vector2d::Zero();  // from pixels to the two sides of the image
  Matrix<2, kNumMonomials> coefficients_ = Matrix<2, kNumMonomials>::Zero();
};

}  // namespace facet
