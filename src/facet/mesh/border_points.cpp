// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/border_points.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "facet/camera/camera_model.h"

namespace facet {
namespace {

/// Of an inverse depth, from that of the depth.
double SigmaOfInverse(const MeshPoint& point) {
  constexpr double kMinRelative = 1e-3;
  const double z = point.p_C.z();
  return std::max(point.sigma_depth_m / z, kMinRelative) / z;
}

}  // namespace

// False where there are too few, or one that makes another point superfluous.
bool BorderPoints::FindNearest(const MeshView& view, const Vector2d& xy) {
  nearest_.clear();
  const double reach = limits_.max_distance_px / view.focal_px;
  const double gap = limits_.min_distance_px / view.focal_px;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const MeshPoint& point = view.points[i];
    const double distance2 = (point.xy - xy).squaredNorm();
    if (!(distance2 <= reach * reach) || !point.p_C.allFinite() || !(point.p_C.z() > kMinDepth_m) ||
        !std::isfinite(point.sigma_depth_m)) {
      continue;
    }
    if (distance2 < gap * gap) return false;
    nearest_.push_back({distance2, static_cast<int>(i)});
  }
  const auto count = static_cast<std::size_t>(limits_.num_neighbours);
  if (nearest_.size() <= count) return nearest_.size() == count;
  std::nth_element(nearest_.begin(),
                   nearest_.begin() + static_cast<std::ptrdiff_t>(count),
                   nearest_.end(),
                   [](const Neighbour& a, const Neighbour& b) {
                     return std::pair(a.distance2, a.point) < std::pair(b.distance2, b.point);
                   });
  nearest_.resize(count);
  return true;
}

// The inverse depth is linear over a plane: weighted least squares with three unknowns, whose
// covariance says how far the plane may be continued.
std::optional<MeshPoint> BorderPoints::Continue(const MeshView& view, const Vector2d& xy) {
  if (!FindNearest(view, xy)) return std::nullopt;
  Matrix3d information = Matrix3d::Zero();
  Vector3d sum = Vector3d::Zero();
  for (const Neighbour& neighbour : nearest_) {
    const MeshPoint& point = view.points[neighbour.point];
    const Vector3d row(1, point.xy.x() - xy.x(), point.xy.y() - xy.y());
    const double weight = 1 / (SigmaOfInverse(point) * SigmaOfInverse(point));
    information += weight * row * row.transpose();
    sum += weight / point.p_C.z() * row;
  }
  const Eigen::LLT<Matrix3d> llt(information);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const Vector3d plane = llt.solve(sum);
  for (const Neighbour& neighbour : nearest_) {
    const MeshPoint& point = view.points[neighbour.point];
    const Vector3d row(1, point.xy.x() - xy.x(), point.xy.y() - xy.y());
    const double residual = std::abs(row.dot(plane) - 1 / point.p_C.z());
    if (!(residual <= limits_.max_sigmas * SigmaOfInverse(point))) return std::nullopt;
  }
  const double variance = llt.solve(Vector3d::UnitX()).x();
  const double sigma = std::sqrt(variance);  // of the inverse depth at xy
  if (!(plane[0] > 0) || !(sigma <= limits_.max_depth_sigma * plane[0])) return std::nullopt;
  MeshPoint point;
  const double z = 1 / plane[0];
  point.xy = xy;
  point.p_C = z * Vector3d(xy.x(), xy.y(), 1);
  point.sigma_depth_m = z * z * sigma;
  point.intensity = view.points[nearest_.front().point].intensity;
  return point;
}

}  // namespace facet
