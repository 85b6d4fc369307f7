// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/view_check.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "facet/camera/camera_model.h"
#include "facet/mesh/stereographic.h"
#include "facet/mesh/triangle_rows.h"

namespace facet {
namespace {

// A view with points farther from the axis than this, as |x/z| or |y/z|, is not projected onto the
// plane z = 1. In the other projection it is 157 deg from the axis, beyond all lenses.
constexpr double kMaxSlope = 10;
constexpr double kCell_px = 8;   // side of a cell of the view: larger is faster and coarser
constexpr int kMaxSide = 400;    // cells
constexpr int kCellsPerBin = 4;  // along the side of a bin of points
constexpr double kFlat = 1e-12;  // twice the area below which a face is seen from its edge
// Relative difference in inverse depth that counts as another surface: 1-sigma of a vertex's depth
// may be as large (FaceLimits::max_depth_sigma).
constexpr double kDepthTolerance = 0.06;
// Share of a face that newer faces must cover to replace it.
constexpr double kMinCovered = 0.7;
// A cell before the view's surface counts this little: the surface itself is only interpolated.
constexpr double kMinFrontShare = 0.3;

bool IsInView(const ProjectedFace& face) {
  const auto& [a, b, c] = face;
  return a.inverse_depth > 0 && b.inverse_depth > 0 && c.inverse_depth > 0;
}

/// Barycentric coordinates of a point as linear functions of its place, and the inverse depth.
struct LinearFace {
  explicit LinearFace(const ProjectedFace& face) : c(face[2].xy) {
    const Vector2d u = face[0].xy - c, v = face[1].xy - c;
    const double area = u.x() * v.y() - u.y() * v.x();
    is_flat = !(std::abs(area) > kFlat);
    if (is_flat) return;
    row0 = Vector2d(v.y(), -v.x()) / area;
    row1 = Vector2d(-u.y(), u.x()) / area;
    slope = (face[0].inverse_depth - face[2].inverse_depth) * row0 +
            (face[1].inverse_depth - face[2].inverse_depth) * row1;
    at_c = face[2].inverse_depth;
  }

  bool Contains(const Vector2d& xy) const {
    const Vector2d d = xy - c;
    const double b0 = row0.dot(d), b1 = row1.dot(d);
    // One branch: which of the three decides cannot be predicted.
    return (static_cast<int>(b0 >= 0) & static_cast<int>(b1 >= 0) &
            static_cast<int>(b0 + b1 <= 1)) != 0;
  }

  Vector2d c, row0, row1;
  Vector2d slope;   // of the inverse depth
  double at_c = 0;  // inverse depth
  bool is_flat = true;
};

Vector2d LowOf(const ProjectedFace& face) {
  return face[0].xy.cwiseMin(face[1].xy).cwiseMin(face[2].xy);
}
Vector2d HighOf(const ProjectedFace& face) {
  return face[0].xy.cwiseMax(face[1].xy).cwiseMax(face[2].xy);
}

}  // namespace

void ViewCheck::Begin(const MeshView& view) {
  points_.clear();
  is_wide_ = std::ranges::any_of(view.points, [](const MeshPoint& point) {
    return point.IsInView() &&
           point.p_C.head<2>().cwiseAbs().maxCoeff() > kMaxSlope * point.p_C.z();
  });
  Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (const MeshPoint& point : view.points) {
    const auto [xy, q] = Project(point.p_C);
    if (q == 0 || xy.cwiseAbs().maxCoeff() > kMaxSlope) continue;
    low = low.cwiseMin(xy);
    high = high.cwiseMax(xy);
    const double sigma_m =
        is_wide_ ? point.sigma_depth_m : point.sigma_depth_m * point.p_C.z() / point.p_C.norm();
    points_.push_back({point.id, xy, q, q * kDepthTolerance + 2 * sigma_m * q * q, 0});
  }
  columns_ = rows_ = 0;
  if (points_.empty()) return;
  cell_ = std::max(kCell_px / view.focal_px, (high - low).maxCoeff() / kMaxSide);
  corner_ = low;
  columns_ = 1 + static_cast<int>((high.x() - low.x()) / cell_);
  rows_ = 1 + static_cast<int>((high.y() - low.y()) / cell_);
  inverse_depth_.assign(static_cast<std::size_t>(columns_ * rows_), 0.0F);
  bins_ = {1 + columns_ / kCellsPerBin, 1 + rows_ / kCellsPerBin};
  for (SeenPoint& point : points_)
    point.bin = BinOf(point.xy);
  std::sort(points_.begin(), points_.end(), [](const SeenPoint& a, const SeenPoint& b) {
    return a.bin != b.bin ? a.bin < b.bin : a.id < b.id;
  });
  first_in_bin_.assign(static_cast<std::size_t>(bins_.columns * bins_.rows + 1), 0);
  for (const SeenPoint& point : points_)
    ++first_in_bin_[point.bin + 1];
  std::partial_sum(first_in_bin_.begin(), first_in_bin_.end(), first_in_bin_.begin());
}

ProjectedPoint ViewCheck::Project(const Vector3d& p_C) const {
  const double depth = is_wide_ ? p_C.norm() : p_C.z();
  if (!p_C.allFinite() || !(depth >= kMinDistance_m)) return {};
  if (!is_wide_) return {p_C.head<2>() * (1 / depth), 1 / depth};
  const Vector2d xy = Stereographic(p_C / depth);
  if (!(xy.cwiseAbs().maxCoeff() <= kMaxSlope)) return {};
  return {xy, 1 / depth};
}

// The nearest one for places outside.
int ViewCheck::BinOf(const Vector2d& xy) const {
  const Vector2d place = (xy - corner_) / (kCellsPerBin * cell_);
  const auto column = static_cast<int>(std::clamp<double>(place.x(), 0, bins_.columns - 1));
  const auto row = static_cast<int>(std::clamp<double>(place.y(), 0, bins_.rows - 1));
  return row * bins_.columns + column;
}

// Calls visit(first cell, number of cells, inverse depth at the first, step to the next) for the
// rows of cells whose centres the face covers.
template <class Visit>
void ViewCheck::VisitRows(const ProjectedFace& face, const Visit& visit) const {
  const LinearFace linear(face);
  if (linear.is_flat || columns_ == 0) return;
  // Coordinates in cells, whose centres are the whole numbers.
  const auto in_cells = [this](const Vector2d& xy) -> Vector2d {
    return (xy - corner_) / cell_ - Vector2d::Constant(0.5);
  };
  const Vector2d c = in_cells(linear.c);
  const Vector2d n0 = cell_ * linear.row0, n1 = cell_ * linear.row1, n2 = -n0 - n1;
  const TriangleRows inside({n0, n1, n2}, {n0.dot(c), n1.dot(c), n2.dot(c) - 1});
  const Vector2d slope = cell_ * linear.slope;
  const double at_origin = linear.at_c - slope.dot(c);
  const WholeNumbers rows =
      WholeNumbersBetween(in_cells(LowOf(face)).y(), in_cells(HighOf(face)).y(), {0, rows_ - 1});
  for (int row = rows.first; row <= rows.last; ++row) {
    const auto [first, last] = inside.Columns(row, {0, columns_ - 1});
    if (first > last) continue;
    const double q = at_origin + slope.y() * row + slope.x() * first;
    visit(row * columns_ + first, last - first + 1, q, slope.x());
  }
}

void ViewCheck::Draw(const ProjectedFace& face) {
  if (!IsInView(face)) return;
  VisitRows(face, [this](int cell, int count, double q, double step) {
    for (int k = 0; k < count; ++k)
      inverse_depth_[cell + k] = static_cast<float>(q + k * step);
  });
}

// Whether it lies beyond all points of the view.
bool ViewCheck::IsBeside(const ProjectedFace& face) const {
  const Vector2d low = (LowOf(face) - corner_) / cell_, high = HighOf(face) - corner_;
  return low.x() > columns_ || low.y() > rows_ || high.x() < 0 || high.y() < 0;
}

int ViewCheck::CountPointsBehind(const ProjectedFace& face,
                                 const std::array<LandmarkId, 3>& corners) const {
  const LinearFace linear(face);
  if (linear.is_flat) return 0;
  const auto is_passed = [&](const SeenPoint& point) {
    if (!linear.Contains(point.xy)) return false;
    const double q = linear.at_c + linear.slope.dot(point.xy - linear.c);
    const bool is_corner = std::find(corners.begin(), corners.end(), point.id) != corners.end();
    return q > point.inverse_depth + point.margin && !is_corner;
  };
  const int first = BinOf(LowOf(face)), last = BinOf(HighOf(face));
  const int width = last % bins_.columns - first % bins_.columns;
  std::ptrdiff_t num = 0;
  for (int bin = first; bin <= last; bin += bins_.columns) {
    const auto begin = points_.begin() + first_in_bin_[bin];
    const auto end = points_.begin() + first_in_bin_[bin + width + 1];
    num += std::count_if(begin, end, is_passed);
  }
  return static_cast<int>(num);
}

FaceVisibility ViewCheck::Judge(const ProjectedFace& face,
                                const std::array<LandmarkId, 3>& corners) const {
  FaceVisibility visibility;
  if (columns_ == 0 || !IsInView(face) || IsBeside(face)) return visibility;
  int covered = 0, before = 0, all = 0;
  VisitRows(face, [&](int cell, int count, double q, double step) {
    const auto q_first = static_cast<float>(q), q_step = static_cast<float>(step);
    const auto tolerance = static_cast<float>(kDepthTolerance);
    all += count;
    for (int k = 0; k < count; ++k) {  // without branches: what is seen cannot be predicted
      const float seen = inverse_depth_[cell + k];
      const float nearer = q_first + static_cast<float>(k) * q_step - seen;
      const float margin = seen * tolerance;
      const int is_seen = seen > 0 ? 1 : 0;
      before += is_seen & (nearer > margin ? 1 : 0);
      covered += is_seen & (std::abs(nearer) <= margin ? 1 : 0);
    }
  });
  visibility.is_covered = all > 0 && covered >= kMinCovered * all;
  visibility.num_seen_through = CountPointsBehind(face, corners);
  if (all > 0 && before >= kMinFrontShare * all) ++visibility.num_seen_through;
  return visibility;
}

}  // namespace facet
