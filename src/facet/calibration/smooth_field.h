// SPDX-License-Identifier: BSD-2-Clause
// A smooth displacement of pixels: polynomials of third order over the image, as what a lens does
// that a few coefficients of distortion cannot say.
#pragma once

#include "facet/base/random.h"
#include "facet/base/types.h"

namespace facet {

/// Monomials x^i y^j with i + j <= 3.
inline constexpr int kNumMonomials = 10;

/// The place of x^i y^j among them.
int MonomialIndex(int i, int j);

class SmoothField {
 public:
  /// None.
  SmoothField() = default;
  /// Columns: of the monomials in the displacement along x and along y [px].
  SmoothField(int width, int height, const Matrix<kNumMonomials, 2>& coefficients)
      : width_(width), height_(height), coefficients_(coefficients) {}

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
  Vector2d At(const Vector2d& px) const;

 private:
  int width_ = 0, height_ = 0;
  Matrix<kNumMonomials, 2> coefficients_ = Matrix<kNumMonomials, 2>::Zero();
};

}  // namespace facet
