// SPDX-License-Identifier: BSD-2-Clause
// One measured pixel as a direction, whatever the lens (docs/math.md, equation (3.3)).
#pragma once

#include <cmath>

#include "facet/base/types.h"

namespace facet {

/// Directions are those of the camera. A direction h is at `whitening * h / bearing.dot(h)` sigmas:
/// its distance from the bearing on the plane that touches the unit sphere there. For a pixel that
/// is predicted where it was measured this is the error in pixels to first order.
struct MeasuredRay {
  Vector3d bearing{0, 0, 1};  ///< unit vector
  /// 1/sigma * d pixel / d direction at the bearing. Times the bearing it is zero.
  Matrix<2, 3> whitening = Matrix<2, 3>::Zero();

  /// h: a direction of about unit length. What is predicted nearly 90 deg away, or beyond, is
  /// nowhere near the bearing, and has no error.
  bool IsNear(const Vector3d& h) const {
    constexpr double kLeastCosine = 0.05;
    return bearing.dot(h) >= kLeastCosine;
  }

  Vector2d Error(const Vector3d& h) const { return whitening * h / bearing.dot(h); }

  /// d Error / d h.
  Matrix<2, 3> ErrorByDirection(const Vector3d& h) const {
    const double scale = 1 / bearing.dot(h);
    return scale * (whitening - scale * (whitening * h) * bearing.transpose());
  }

  /// Of a small angle across the bearing, the geometric mean over its directions [1/rad^2].
  double AngleInformation() const {
    const Matrix2d information = whitening * whitening.transpose();
    return std::sqrt(information.determinant());
  }
};

}  // namespace facet
