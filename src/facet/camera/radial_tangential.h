// SPDX-License-Identifier: BSD-2-Clause
// The radial-tangential model [k1 k2 p1 p2] on the plane z = 1: most lenses are described by it,
// and that of a unified camera is behind its sphere. Inline, because every projection goes through
// it.
#pragma once

#include "facet/base/types.h"
#include "facet/camera/camera_intrinsics.h"

namespace facet {

/// Where the radial part of a lens puts a radius, and the derivative of that.
struct LensRadius {
  double value = 0;
  double slope = 1;  ///< 0 where there is no image any more
};

/// r: distance from the axis. Tangential terms are left out.
inline LensRadius RadialTangentialRadius(const CameraIntrinsics& k, double r) {
  const double r2 = r * r;
  const auto& c = k.coefficients;
  return {r * (1 + r2 * (c[0] + r2 * c[1])), 1 + r2 * (3 * c[0] + 5 * r2 * c[1])};
}

/// From the ideal to the distorted point. J: d result / d xy.
inline Vector2d DistortRadialTangential(const CameraIntrinsics& k,
                                        const Vector2d& xy,
                                        Matrix2d* J) {
  const double k1 = k.coefficients[0], k2 = k.coefficients[1];
  const double p1 = k.coefficients[2], p2 = k.coefficients[3];
  const double x = xy.x(), y = xy.y(), r2 = xy.squaredNorm();
  const double radial = 1 + r2 * (k1 + r2 * k2);
  if (J) {
    const double d = 2 * (k1 + 2 * r2 * k2);  // d radial / d x = d x
    const double off = d * x * y + 2 * (p1 * x + p2 * y);
    *J << radial + d * x * x + 2 * p1 * y + 6 * p2 * x, off,  //
        off, radial + d * y * y + 6 * p1 * y + 2 * p2 * x;
  }
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y * y)};
}

/// d distorted / d [k1 k2 p1 p2].
inline Matrix<2, 4> RadialTangentialColumns(const Vector2d& xy) {
  const double x = xy.x(), y = xy.y(), r2 = xy.squaredNorm();
  Matrix<2, 4> J;
  J << x * r2, x * r2 * r2, 2 * x * y, r2 + 2 * x * x,  //
      y * r2, y * r2 * r2, r2 + 2 * y * y, 2 * x * y;
  return J;
}

}  // namespace facet
