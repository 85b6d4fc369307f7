// SPDX-License-Identifier: BSD-2-Clause
// A landmark as a homogeneous point of the world (docs/math.md, equation (3.1)).
#pragma once

#include "facet/estimator/window/frame_geometry.h"
#include "facet/estimator/window/window_landmark.h"
#include "facet/geometry/so3.h"

namespace facet {

/// X = p_WH + d_W / rho; for rho = 0 a direction.
struct HostedPoint {
  Vector3d d_W;
  Vector3d p_WH;  ///< left camera of the host
  double rho;

  HostedPoint(const WindowLandmark& landmark, const FrameGeometry::Pose& host)
      : d_W(host.R_WC0 * landmark.bearing_H), p_WH(host.p_WC0), rho(landmark.inverse_distance) {}

  /// Times rho, as seen from p_W, in the axes of the world.
  Vector3d SeenFrom(const Vector3d& p_W) const { return d_W + rho * (p_WH - p_W); }
};

/// The landmark where residuals are taken, and where Jacobians are.
struct LinearizedPoint {
  HostedPoint current;
  HostedPoint frozen;
  Matrix<3, 2> B_W;  ///< tangent of the bearing, in the world

  LinearizedPoint(const WindowLandmark& landmark, const FrameGeometry& geometry)
      : current(landmark, geometry.current(landmark.host)),
        frozen(landmark, geometry.frozen(landmark.host)),
        B_W(geometry.frozen(landmark.host).R_WC0 * TangentBasis(landmark.bearing_H)) {}
};

}  // namespace facet
