// SPDX-License-Identifier: BSD-2-Clause
#include "facet/geometry/plane_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "facet/base/check.h"

namespace facet {

PlaneFit FitPlane(std::span<const Vector3d> points, std::span<const double> weights) {
  FACET_CHECK(!points.empty() && (weights.empty() || weights.size() == points.size()))
      << points.size() << " points, " << weights.size() << " weights";
  const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };
  PlaneFit fit;
  double total = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    fit.centroid += weight(i) * points[i];
    total += weight(i);
  }
  fit.centroid /= total;
  Matrix3d scatter = Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d r = points[i] - fit.centroid;
    scatter += weight(i) * (r * r.transpose());
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(scatter / total);
  const Vector3d spread = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();  // ascending
  fit.thickness_m = spread(0);
  fit.extent_minor_m = spread(1);
  fit.extent_major_m = spread(2);
  fit.major_W = eigen.eigenvectors().col(2);
  fit.plane.n = eigen.eigenvectors().col(0);
  fit.plane.d = fit.plane.n.dot(fit.centroid);
  return fit;
}

}  // namespace facet
