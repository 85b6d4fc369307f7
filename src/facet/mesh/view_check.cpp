// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/view_check.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr double kMinDepth_m = 0.05;
constexpr int kMaxSide = 400;    // cells
constexpr double kFlat = 1e-12;  // twice the area below which a face is seen from its edge
// A cell before the view's surface counts this little: the surface itself is only interpolated.
constexpr double kMinFrontShare = 0.3;

/// Barycentric coordinates of a point as linear functions of its place.
struct Barycentric {
  explicit Barycentric(const std::array<Vector2d, 3>& xy) : c(xy[2]) {
    const Vector2d u = xy[0] - c, v = xy[1] - c;
    const double area = u.x() * v.y() - u.y() * v.x();
    is_flat = !(std::abs(area) > kFlat);
    if (is_flat) return;
    row0 = Vector2d(v.y(), -v.x()) / area;
    row1 = Vector2d(-u.y(), u.x()) / area;
  }

  /// Whether the point is inside; the interpolated value of the corners then.
  bool Interpolate(const Vector2d& xy, const std::array<double, 3>& values, double* value) const {
    const Vector2d d = xy - c;
    const double b0 = row0.dot(d), b1 = row1.dot(d), b2 = 1 - b0 - b1;
    // One branch: which of the three decides cannot be predicted.
    const bool is_outside = static_cast<bool>(static_cast<int>(b0 < 0) | static_cast<int>(b1 < 0) |
                                              static_cast<int>(b2 < 0));
    if (is_outside) return false;
    *value = b0 * values[0] + b1 * values[1] + b2 * values[2];
    return true;
  }

  Vector2d c, row0, row1;
  bool is_flat = true;
};

}  // namespace

bool ProjectFace(const std::array<Vector3d, 3>& p_C, ProjectedFace& face) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(p_C[i].z() >= kMinDepth_m)) return false;
    face.inverse_depth[i] = 1 / p_C[i].z();
    face.xy[i] = p_C[i].head<2>() * face.inverse_depth[i];
  }
  return true;
}

void ViewCheck::Begin(const MeshView& view) {
  points_.clear();
  Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (const MeshPoint& point : view.points) {
    if (!point.p_C.allFinite() || !(point.p_C.z() >= kMinDepth_m)) continue;
    const double q = 1 / point.p_C.z();
    const Vector2d xy = point.p_C.head<2>() * q;
    if (xy.cwiseAbs().maxCoeff() > 10) continue;
    low = low.cwiseMin(xy);
    high = high.cwiseMax(xy);
    points_.push_back(
        {point.id, xy, q, q * options_.depth_tolerance + 2 * point.sigma_depth_m * q * q});
  }
  columns_ = rows_ = 0;
  if (points_.empty()) return;
  cell_ = std::max(options_.cell_px / view.focal_px, (high - low).maxCoeff() / kMaxSide);
  corner_ = low;
  columns_ = 1 + static_cast<int>((high.x() - low.x()) / cell_);
  rows_ = 1 + static_cast<int>((high.y() - low.y()) / cell_);
  inverse_depth_.assign(static_cast<std::size_t>(columns_ * rows_), 0.0F);
  std::sort(points_.begin(), points_.end(), [](const SeenPoint& a, const SeenPoint& b) {
    if (a.xy.y() != b.xy.y()) return a.xy.y() < b.xy.y();
    return a.id < b.id;
  });
  first_in_row_.assign(static_cast<std::size_t>(rows_ + 1), static_cast<int>(points_.size()));
  for (int i = static_cast<int>(points_.size()) - 1; i >= 0; --i) {
    const int row = static_cast<int>((points_[i].xy.y() - corner_.y()) / cell_);
    first_in_row_[std::min(row, rows_ - 1)] = i;
  }
  for (int row = rows_ - 1; row >= 0; --row)
    first_in_row_[row] = std::min(first_in_row_[row], first_in_row_[row + 1]);
}

// Calls visit(cell, inverse depth of the face) for the cells whose centres the face covers.
template <class Visit>
void ViewCheck::VisitCells(const ProjectedFace& face, const Visit& visit) const {
  const Barycentric barycentric(face.xy);
  if (barycentric.is_flat || columns_ == 0) return;
  const Vector2d low = face.xy[0].cwiseMin(face.xy[1]).cwiseMin(face.xy[2]) - corner_;
  const Vector2d high = face.xy[0].cwiseMax(face.xy[1]).cwiseMax(face.xy[2]) - corner_;
  const auto index = [&](double x, int count) {
    // Rounded towards zero from 0 on; below, any negative number does.
    const double place = std::clamp(x / cell_, -1.0, static_cast<double>(count));
    return place < 0 ? -1 : static_cast<int>(place);
  };
  const int column_end = std::min(index(high.x(), columns_) + 1, columns_);
  const int row_end = std::min(index(high.y(), rows_) + 1, rows_);
  for (int row = std::max(index(low.y(), rows_), 0); row < row_end; ++row) {
    for (int column = std::max(index(low.x(), columns_), 0); column < column_end; ++column) {
      const Vector2d centre = corner_ + cell_ * Vector2d(column + 0.5, row + 0.5);
      double q = 0;
      if (barycentric.Interpolate(centre, face.inverse_depth, &q))
        visit(row * columns_ + column, q);
    }
  }
}

void ViewCheck::Draw(const ProjectedFace& face) {
  VisitCells(face, [this](int cell, double q) { inverse_depth_[cell] = static_cast<float>(q); });
}

int ViewCheck::CountSightingsThrough(const ProjectedFace& face,
                                     const std::array<LandmarkId, 3>& corners) const {
  const Barycentric barycentric(face.xy);
  if (barycentric.is_flat) return 0;
  const Vector2d low = face.xy[0].cwiseMin(face.xy[1]).cwiseMin(face.xy[2]);
  const Vector2d high = face.xy[0].cwiseMax(face.xy[1]).cwiseMax(face.xy[2]);
  const double first_row = std::floor((low.y() - corner_.y()) / cell_);
  if (first_row >= rows_ || high.y() < corner_.y()) return 0;
  int votes = 0;
  for (int i = first_in_row_[std::max(static_cast<int>(first_row), 0)];
       i < static_cast<int>(points_.size()) && points_[i].xy.y() <= high.y();
       ++i) {
    const SeenPoint& point = points_[i];
    if (point.xy.x() < low.x() || point.xy.x() > high.x()) continue;
    double q = 0;
    if (!barycentric.Interpolate(point.xy, face.inverse_depth, &q)) continue;
    const bool is_before = q > point.inverse_depth + point.margin;
    const bool is_corner = std::find(corners.begin(), corners.end(), point.id) != corners.end();
    votes += is_before && !is_corner ? 1 : 0;
  }
  return votes;
}

FaceSighting ViewCheck::Judge(const ProjectedFace& face,
                              const std::array<LandmarkId, 3>& corners) const {
  FaceSighting sighting;
  if (columns_ == 0) return sighting;
  int covered = 0, before = 0, all = 0;
  VisitCells(face, [&](int cell, double q) {
    ++all;
    const double seen = inverse_depth_[cell];
    if (seen <= 0) return;
    const double margin = seen * options_.depth_tolerance;
    before += q > seen + margin ? 1 : 0;
    covered += std::abs(q - seen) <= margin ? 1 : 0;
  });
  sighting.is_replaced = all > 0 && covered >= options_.min_covered * all;
  sighting.votes_against = CountSightingsThrough(face, corners);
  if (all > 0 && before >= kMinFrontShare * all) ++sighting.votes_against;
  return sighting;
}

}  // namespace facet
