// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/triangle_index.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "facet/geometry/triangle.h"

namespace facet {
namespace {

constexpr int kLeafSize = 4;
constexpr double kSmallestArea = 1e-12;  // m^2

// Moeller and Trumbore: t of the line at the triangle.
std::optional<double> LineOnTriangle(const Vector3d& p,
                                     const Vector3d& direction,
                                     const Vector3d& a,
                                     const Vector3d& b,
                                     const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a;
  const Vector3d h = direction.cross(ac);
  const double determinant = ab.dot(h);
  if (determinant == 0) return std::nullopt;
  const Vector3d s = p - a;
  const double u = s.dot(h) / determinant;
  if (u < 0 || u > 1) return std::nullopt;
  const Vector3d q = s.cross(ab);
  const double v = direction.dot(q) / determinant;
  if (v < 0 || u + v > 1) return std::nullopt;
  return ac.dot(q) / determinant;
}

bool LineMeetsBox(const Vector3d& p,
                  const Vector3d& inverse_direction,
                  double t_min,
                  double t_max,
                  const Eigen::AlignedBox3d& box) {
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(inverse_direction[i])) {  // the line runs along this side of the box
      if (p[i] < box.min()[i] || p[i] > box.max()[i]) return false;
      continue;
    }
    double t0 = (box.min()[i] - p[i]) * inverse_direction[i];
    double t1 = (box.max()[i] - p[i]) * inverse_direction[i];
    if (t0 > t1) std::swap(t0, t1);
    if (t0 > t_min) t_min = t0;
    if (t1 < t_max) t_max = t1;
    if (t_min > t_max) return false;
  }
  return true;
}

}  // namespace

Vector3d FaceNormal(const TriangleMesh& mesh, int face) {
  const auto& [i, j, k] = mesh.faces[face];
  const Vector3d& a = mesh.vertices[i];
  const Vector3d cross = (mesh.vertices[j] - a).cross(mesh.vertices[k] - a);
  const double norm = cross.norm();
  return norm > 0 ? Vector3d(cross / norm) : Vector3d::Zero();
}

double FaceArea(const TriangleMesh& mesh, int face) {
  const auto& [i, j, k] = mesh.faces[face];
  const Vector3d& a = mesh.vertices[i];
  return 0.5 * (mesh.vertices[j] - a).cross(mesh.vertices[k] - a).norm();
}

TriangleIndex::TriangleIndex(const TriangleMesh& mesh) {
  triangles_.reserve(mesh.faces.size());
  for (int f = 0; f < static_cast<int>(mesh.faces.size()); ++f) {
    if (FaceArea(mesh, f) < kSmallestArea) continue;
    const auto& [i, j, k] = mesh.faces[f];
    triangles_.push_back({mesh.vertices[i], mesh.vertices[j], mesh.vertices[k], f});
  }
  nodes_.reserve(triangles_.size());
  if (!triangles_.empty()) Build(0, static_cast<int>(triangles_.size()));
}

int TriangleIndex::Build(int begin, int end) {
  const int index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Eigen::AlignedBox3d box, centres;
  for (int i = begin; i < end; ++i) {
    const Triangle& t = triangles_[i];
    box.extend(t.a).extend(t.b).extend(t.c);
    centres.extend(Vector3d(t.a + t.b + t.c));
  }
  nodes_[index].box = box;
  nodes_[index].begin = begin;
  nodes_[index].end = end;
  if (end - begin <= kLeafSize) return index;
  int axis = 0;
  centres.sizes().maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  std::nth_element(triangles_.begin() + begin,
                   triangles_.begin() + middle,
                   triangles_.begin() + end,
                   [axis](const Triangle& s, const Triangle& t) {
                     return s.a[axis] + s.b[axis] + s.c[axis] < t.a[axis] + t.b[axis] + t.c[axis];
                   });
  const int left = Build(begin, middle);
  const int right = Build(middle, end);
  nodes_[index].left = left;
  nodes_[index].right = right;
  return index;
}

std::optional<SurfacePoint> TriangleIndex::Closest(const Vector3d& p, double max_distance) const {
  if (nodes_.empty()) return std::nullopt;
  double best = max_distance * max_distance;
  const Triangle* nearest = nullptr;
  SurfacePoint result;
  // Depth of the tree is logarithmic (median splits), so this stack always suffices.
  std::array<std::pair<int, double>, 128> stack;  // NOLINT(*-member-init): filled as it grows
  int size = 0;
  stack[size++] = {0, nodes_[0].box.squaredExteriorDistance(p)};
  while (size > 0) {
    const auto [index, lower_bound] = stack[--size];
    if (lower_bound > best) continue;
    const Node& node = nodes_[index];
    if (node.left < 0) {
      for (int i = node.begin; i < node.end; ++i) {
        const Triangle& t = triangles_[i];
        const Vector3d q = ClosestOnTriangle(p, t.a, t.b, t.c);
        const double squared = (q - p).squaredNorm();
        if (squared > best) continue;
        best = squared;
        nearest = &t;
        result.p = q;
      }
      continue;
    }
    std::pair<int, double> near{node.left, nodes_[node.left].box.squaredExteriorDistance(p)};
    std::pair<int, double> far{node.right, nodes_[node.right].box.squaredExteriorDistance(p)};
    if (far.second < near.second) std::swap(near, far);
    stack[size++] = far;
    stack[size++] = near;
  }
  if (nearest == nullptr) return std::nullopt;
  result.n = (nearest->b - nearest->a).cross(nearest->c - nearest->a).normalized();
  result.distance = std::sqrt(best);
  result.face = nearest->face;
  return result;
}

void TriangleIndex::VisitLine(const Vector3d& p,
                              const Vector3d& direction,
                              double t_min,
                              double t_max,
                              const std::function<bool(int face, double t)>& visit) const {
  if (nodes_.empty()) return;
  const Vector3d inverse_direction = direction.cwiseInverse();
  std::array<int, 128> stack;  // NOLINT(*-member-init): filled as it grows
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const Node& node = nodes_[stack[--size]];
    if (!LineMeetsBox(p, inverse_direction, t_min, t_max, node.box)) continue;
    if (node.left >= 0) {
      stack[size++] = node.left;
      stack[size++] = node.right;
      continue;
    }
    for (int i = node.begin; i < node.end; ++i) {
      const Triangle& t = triangles_[i];
      const auto hit = LineOnTriangle(p, direction, t.a, t.b, t.c);
      if (hit && *hit >= t_min && *hit <= t_max && !visit(t.face, *hit)) return;
    }
  }
}

}  // namespace facet
