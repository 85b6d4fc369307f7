// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/point_on_plane_factor.h"

#include <cmath>

#include "facet/estimator/factors/robust_loss.h"
#include "facet/geometry/so3.h"

namespace facet {

// n . (X - anchor) - offset, X = p_host + d / rho.
double PointOnPlaneFactor::Error(const HostedPoint& point) const {
  return plane_.SignedDistance(point.p_WH + point.d_W / point.rho) / sigma_m_;
}

double PointOnPlaneFactor::Cost(const HostedPoint& point) const {
  return HuberLoss(std::abs(Error(point)), noise_.plane_huber_sigma).cost;
}

void PointOnPlaneFactor::AddTo(const LinearizedPoint& point, LandmarkBlock& block) const {
  const double error = Error(point.current);
  const RobustLoss loss = HuberLoss(std::abs(error), noise_.plane_huber_sigma);
  block.cost += loss.cost;
  const double distance = 1.0 / point.frozen.rho;
  const Vector3d l_W = point.frozen.p_WH + point.frozen.d_W * distance;
  const double scale = loss.root_weight / sigma_m_;
  LandmarkBlock::PlaneView& view =
      block.plane_views[static_cast<std::size_t>(block.num_plane_views++)];
  view.plane = index_;
  view.J_plane << scale * (TangentBasis(plane_.n_lin).transpose() * (l_W - plane_.anchor_W)),
      -scale;
  view.J_landmark << scale * distance * (point.B_W.transpose() * plane_.n_lin),
      -scale * distance * distance * plane_.n_lin.dot(point.frozen.d_W);
  view.residual = loss.root_weight * error;
  block.V += view.J_landmark * view.J_landmark.transpose();
  block.b += view.J_landmark * view.residual;
}

}  // namespace facet
