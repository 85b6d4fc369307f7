// SPDX-License-Identifier: BSD-2-Clause
// A face among the columns of a grid: which of them it meets, and where.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "facet/base/types.h"
#include "facet/mesh/triangle_rows.h"

namespace facet {

/// A linear function of a place across the columns of the grid.
struct ColumnFunction {
  Vector2d slope = Vector2d::Zero();
  double at_origin = 0;
  double operator()(double x, double y) const { return at_origin + slope.x() * x + slope.y() * y; }
};

/// A face as a plane with a border, seen along the axis of the grid that its normal is nearest to.
/// In voxels.
struct FlatFace {
  static constexpr double kMaxCoordinate = 1e7, kMinTwiceArea = 1e-7;  // voxels

  explicit FlatFace(const std::array<Vector3d, 3>& p) {
    const Vector3d twice_area = (p[1] - p[0]).cross(p[2] - p[0]);
    for (const Vector3d& corner : p)
      is_valid = is_valid && corner.cwiseAbs().maxCoeff() < kMaxCoordinate;
    is_valid = is_valid && twice_area.norm() > kMinTwiceArea;
    if (!is_valid) return;
    n = twice_area.normalized();
    n.cwiseAbs().maxCoeff(&w);
    u = (w + 1) % 3;
    v = (w + 2) % 3;
    plane.slope = -Vector2d(n[u], n[v]) / n[w];
    plane.at_origin = p[0][w] - plane.slope.dot(Vector2d(p[0][u], p[0][v]));
    const double side = n[w] > 0 ? 1 : -1;  // corners are counter-clockwise seen against n
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d& from = p[(i + 1) % 3];
      const Vector3d along = p[(i + 2) % 3] - from;
      inward[i] = side * Vector2d(-along[v], along[u]).normalized();
      offset[i] = inward[i].dot(Vector2d(from[u], from[v]));
      const double height = inward[i].dot(Vector2d(p[i][u], p[i][v])) - offset[i];
      share[i].slope = inward[i] / std::max(height, 1e-9);
      share[i].at_origin = -offset[i] / std::max(height, 1e-9);
    }
  }

  /// Continued beyond the border.
  ColumnFunction Interpolate(const std::array<std::uint8_t, 3>& values) const {
    ColumnFunction sum;
    for (std::size_t i = 0; i < 3; ++i) {
      sum.slope += values[i] * share[i].slope;
      sum.at_origin += values[i] * share[i].at_origin;
    }
    return sum;
  }

  /// The columns of the grid that meet the face or pass at most `border` beside each side.
  TriangleRows Inside(const std::array<double, 3>& border) const {
    return {inward, {offset[0] - border[0], offset[1] - border[1], offset[2] - border[2]}};
  }

  Vector3d n = Vector3d::Zero();
  int u = 0, v = 1, w = 2;         // axes across the columns, and along them
  ColumnFunction plane;            // where the columns meet it
  std::array<Vector2d, 3> inward;  // of the side opposite to corner i, across the columns
  std::array<double, 3> offset{};
  std::array<ColumnFunction, 3> share;  // barycentric coordinates
  bool is_valid = true;
};

/// The columns of the grid along which a face is merged: its own, and what is expected beyond its
/// boundary.
class Footprint {
 public:
  /// Faces reach this many voxels beyond their border: neighbours must meet.
  static constexpr double kBorderVoxels = 0.3;

  Footprint(const FlatFace& flat,
            const std::array<Vector3d, 3>& p,
            const std::array<bool, 3>& is_boundary,
            double boundary)
      : own_(flat.Inside({kBorderVoxels, kBorderVoxels, kBorderVoxels})), all_(own_) {
    double widest = kBorderVoxels;
    if (is_boundary[0] || is_boundary[1] || is_boundary[2]) {
      widest = std::max(kBorderVoxels, boundary);
      const auto border = [&](std::size_t i) { return is_boundary[i] ? widest : kBorderVoxels; };
      all_ = flat.Inside({border(0), border(1), border(2)});
      has_boundary_ = true;
    }
    const Vector3d low = p[0].cwiseMin(p[1]).cwiseMin(p[2]) - Vector3d::Constant(widest);
    const Vector3d high = p[0].cwiseMax(p[1]).cwiseMax(p[2]) + Vector3d::Constant(widest);
    constexpr WholeNumbers kAnywhere = {std::numeric_limits<int>::min(),
                                        std::numeric_limits<int>::max()};
    columns_ = WholeNumbersBetween(low[flat.u], high[flat.u], kAnywhere);
    rows_ = WholeNumbersBetween(low[flat.v], high[flat.v], kAnywhere);
  }

  const WholeNumbers& rows() const { return rows_; }
  WholeNumbers Columns(int row) const { return all_.Columns(row, columns_); }
  /// Those of them that are the face's own.
  WholeNumbers Own(int row, const WholeNumbers& columns) const {
    return has_boundary_ ? own_.Columns(row, columns) : columns;
  }

 private:
  TriangleRows own_, all_;
  WholeNumbers columns_, rows_;
  bool has_boundary_ = false;
};

}  // namespace facet
