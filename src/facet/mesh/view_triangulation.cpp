// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/view_triangulation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "facet/mesh/stereographic.h"

namespace facet {
namespace {

constexpr double kGridPerPixel = 16;
constexpr double kMinZ = -0.5;  // of the bearing of a point that can be triangulated: 120 deg
// Deviation of surrounding points from a face's plane, seen from the corner, up to which they are
// plane; tracks are some pixels, about a degree, off.
constexpr double kMaxRescueDeviation_deg = 6;

bool IsUsable(const MeshPoint& point) {
  constexpr double kRounding = 1e-6;
  return point.id.IsValid() && std::abs(point.bearing.norm() - 1) < kRounding &&
         point.bearing.z() > kMinZ && point.IsInView();
}

// Limits of faces whose surroundings are plane: those that tell a gap between two surfaces are
// wide.
FaceLimits RescueLimits(const MeshOptions& options) {
  FaceLimits limits = options.faces;
  limits.min_elongation = 0.08;
  limits.max_grazing_deg = 86;
  limits.max_side_per_depth = options.plane_rescue.max_side_per_depth;
  return limits;
}

}  // namespace

bool IsUsable(const MeshView& view) {
  constexpr double kMaxFocal_px = 1e5;  // of the grid of the triangulation
  return view.T_WC.p.allFinite() && view.T_WC.q.coeffs().allFinite() && view.focal_px > 0 &&
         view.focal_px <= kMaxFocal_px;
}

ViewTriangulation::ViewTriangulation(const MeshOptions& options)
    : rescues_planes_(options.plane_rescue.enabled),
      accepted_(options.faces),
      voting_(options.voting),
      rescued_(RescueLimits(options)) {}

void ViewTriangulation::Build(const MeshView& view) {
  ListPoints(view);
  JudgeTriangles(view);
  stars_.Build(
      points_.size(), triangles_.size(), [this](std::size_t t) -> const auto& {
        return triangles_[t].points;
      });
  if (rescues_planes_) RescuePlanes(view);
}

void ViewTriangulation::ListPoints(const MeshView& view) {
  points_.clear();
  for (int i = 0; i < static_cast<int>(view.points.size()); ++i) {
    if (IsUsable(view.points[i])) points_.push_back(i);
  }
  const auto id_of = [&](int i) { return view.points[i].id; };
  std::sort(points_.begin(), points_.end(), [&](int i, int j) { return id_of(i) < id_of(j); });
  const auto same = [&](int i, int j) { return id_of(i) == id_of(j); };
  points_.erase(std::unique(points_.begin(), points_.end(), same), points_.end());
  grid_.clear();
  for (const int i : points_) {
    const Vector2d place = (view.focal_px * kGridPerPixel) * Stereographic(view.points[i].bearing);
    grid_.push_back({static_cast<std::int32_t>(std::lround(place.x())),
                     static_cast<std::int32_t>(std::lround(place.y()))});
  }
}

void ViewTriangulation::JudgeTriangles(const MeshView& view) {
  triangles_.clear();
  for (const std::array<int, 3>& corners : delaunay_.Triangulate(grid_)) {
    Triangle& triangle = triangles_.emplace_back();
    triangle.points = corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const MeshPoint& point = view.points[points_[corners[i]]];
      triangle.seen.p_C[i] = point.p_C;
      triangle.seen.sigma_depth_m[i] = point.sigma_depth_m;
    }
    triangle.defect = accepted_.Judge(triangle.seen);
  }
}

void ViewTriangulation::RescuePlanes(const MeshView& view) {
  for (Triangle& triangle : triangles_) {
    if (triangle.IsAccepted() || triangle.defect == FaceDefect::kNotFinite) continue;
    if (rescued_.Judge(triangle.seen) == FaceDefect::kNone && HasPlaneCorner(view, triangle)) {
      triangle.defect = FaceDefect::kNone;
    }
  }
}

// Whether all points around one of the corners lie in the triangle's plane.
bool ViewTriangulation::HasPlaneCorner(const MeshView& view, const Triangle& triangle) const {
  constexpr std::size_t kMinStar = 4;  // fewer triangles around a corner say little
  const auto& [a, b, c] = triangle.seen.p_C;
  const Vector3d n_C = (b - a).cross(c - a).normalized();
  const double slope = std::tan(kMaxRescueDeviation_deg * std::numbers::pi / 180);
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const int centre = triangle.points[corner];
    const std::span<const int> star = stars_.Around(centre);
    if (star.size() < kMinStar) continue;
    const auto lies_in_plane = [&](int other) {
      const MeshPoint& point = view.points[points_[other]];
      const Vector3d d = point.p_C - triangle.seen.p_C[corner];
      const double noise = std::abs(n_C.dot(point.p_C)) / point.p_C.norm() * point.sigma_depth_m;
      return std::abs(n_C.dot(d)) <= slope * d.norm() + noise;
    };
    const bool is_plane = std::all_of(star.begin(), star.end(), [&](int t) {
      const auto& points = triangles_[t].points;
      return std::all_of(points.begin(), points.end(), lies_in_plane);
    });
    if (is_plane) return true;
  }
  return false;
}

bool ViewTriangulation::IsBoundary(const Triangle& triangle, std::size_t corner) const {
  const int from = triangle.points[(corner + 1) % 3], to = triangle.points[(corner + 2) % 3];
  const std::span<const int> star = stars_.Around(from);
  return std::none_of(star.begin(), star.end(), [&](int t) {
    const Triangle& other = triangles_[t];
    return other.IsAccepted() && other.points != triangle.points &&
           std::find(other.points.begin(), other.points.end(), to) != other.points.end();
  });
}

}  // namespace facet
