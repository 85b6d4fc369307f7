// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/surface_curvature.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "facet/geometry/so3.h"

namespace facet {

namespace {

constexpr std::size_t kMinPoints = 10;
constexpr double kMinSize_m = 0.006;
// Right planes have 0.1 to 3.3 squared sigmas (3 degrees of freedom), things on a shelf 5 to 6, two
// boards in one plane 9.
constexpr double kMaxCurvatureChiSquare = 4;

}  // namespace

std::optional<SurfaceCurvature> FitCurvature(std::span<const Vector3d> points_W,
                                             std::span<const double> weights,
                                             const Vector3d& n_W) {
  if (points_W.size() < kMinPoints) return std::nullopt;
  Vector3d centre_W = Vector3d::Zero();
  double total = 0;
  for (std::size_t i = 0; i < points_W.size(); ++i) {
    centre_W += weights[i] * points_W[i];
    total += weights[i];
  }
  centre_W /= total;
  const Matrix<3, 2> B = TangentBasis(n_W);
  Matrix<6, 6> information = Matrix<6, 6>::Zero();
  Vector<6> b = Vector<6>::Zero();
  for (std::size_t i = 0; i < points_W.size(); ++i) {
    const Vector3d p = points_W[i] - centre_W;
    const Vector2d x = B.transpose() * p;
    Vector<6> row;
    row << 1, x.x(), x.y(), x.x() * x.x(), x.x() * x.y(), x.y() * x.y();
    information += weights[i] * row * row.transpose();
    b += weights[i] * n_W.dot(p) * row;
  }
  const Eigen::LLT<Matrix<6, 6>> second_order(information);
  const Eigen::LLT<Matrix3d> first_order(information.topLeftCorner<3, 3>());
  if (second_order.info() != Eigen::Success || first_order.info() != Eigen::Success)
    return std::nullopt;
  const double gain =
      b.dot(second_order.solve(b)) - b.head<3>().dot(first_order.solve(b.head<3>()));
  if (!std::isfinite(gain)) return std::nullopt;
  return SurfaceCurvature{gain, std::sqrt(std::max(gain, 0.0) / total)};
}

bool IsCurved(const SurfaceCurvature& curvature) {
  return curvature.chi_square > kMaxCurvatureChiSquare && curvature.size_m > kMinSize_m;
}

}  // namespace facet
