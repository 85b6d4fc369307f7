// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/border_points.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

/// Of an inverse distance, from that of the distance.
double SigmaOfInverse(const MeshPoint& point) {
  constexpr double kMinRelative = 1e-3;
  const double distance_m = point.p_C.norm();
  return std::max(point.sigma_depth_m / distance_m, kMinRelative) / distance_m;
}

/// Columns: the place itself, and two directions across it.
Matrix3d FrameOf(const Vector3d& place) {
  Matrix3d frame;
  frame << place, TangentBasis(place);
  return frame;
}

}  // namespace

// False where there are too few, or one that makes another point superfluous.
bool BorderPoints::FindNearest(const MeshView& view, const Vector3d& place) {
  nearest_.clear();
  const double reach = limits_.max_distance_px / view.focal_px;
  const double gap = limits_.min_distance_px / view.focal_px;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const MeshPoint& point = view.points[i];
    const double distance2 = (point.bearing - place).squaredNorm();
    if (!(distance2 <= reach * reach) || !point.IsInView()) {
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

// The inverse distance of a plane is linear in the bearing: weighted least squares with three
// unknowns, whose covariance says how far the plane may be continued.
std::optional<MeshPoint> BorderPoints::Continue(const MeshView& view, const Vector3d& place) {
  if (!FindNearest(view, place)) return std::nullopt;
  const Matrix3d frame = FrameOf(place);
  Matrix3d information = Matrix3d::Zero();
  Vector3d sum = Vector3d::Zero();
  for (const Neighbour& neighbour : nearest_) {
    const MeshPoint& point = view.points[neighbour.point];
    const Vector3d row = frame.transpose() * point.bearing;
    const double weight = 1 / (SigmaOfInverse(point) * SigmaOfInverse(point));
    information += weight * row * row.transpose();
    sum += weight / point.p_C.norm() * row;
  }
  const Eigen::LLT<Matrix3d> llt(information);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const Vector3d plane = llt.solve(sum);
  for (const Neighbour& neighbour : nearest_) {
    const MeshPoint& point = view.points[neighbour.point];
    const Vector3d row = frame.transpose() * point.bearing;
    const double residual = std::abs(row.dot(plane) - 1 / point.p_C.norm());
    if (!(residual <= limits_.max_sigmas * SigmaOfInverse(point))) return std::nullopt;
  }
  const double variance = llt.solve(Vector3d::UnitX()).x();
  const double sigma = std::sqrt(variance);  // of the inverse distance at the place
  if (!(plane[0] > 0) || !(sigma <= limits_.max_depth_sigma * plane[0])) return std::nullopt;
  MeshPoint point;
  const double distance_m = 1 / plane[0];
  point.bearing = place;
  point.p_C = distance_m * place;
  point.sigma_depth_m = distance_m * distance_m * sigma;
  point.intensity = view.points[nearest_.front().point].intensity;
  return point;
}

}  // namespace facet
