// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/surface_bend.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace facet {

namespace {

constexpr std::size_t kMinPoints = 10;
constexpr double kMinBend_m = 0.006;

}  // namespace

std::optional<SurfaceBend> FitBend(std::span<const Vector3d> points_W,
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
  const Eigen::LLT<Matrix<6, 6>> bent(information);
  const Eigen::LLT<Matrix3d> flat(information.topLeftCorner<3, 3>());
  if (bent.info() != Eigen::Success || flat.info() != Eigen::Success) return std::nullopt;
  const double gain = b.dot(bent.solve(b)) - b.head<3>().dot(flat.solve(b.head<3>()));
  if (!std::isfinite(gain)) return std::nullopt;
  return SurfaceBend{gain, std::sqrt(std::max(gain, 0.0) / total)};
}

bool IsBent(const SurfaceBend& bend, double max_chi_square) {
  return bend.chi_square > max_chi_square && bend.size_m > kMinBend_m;
}

}  // namespace facet
