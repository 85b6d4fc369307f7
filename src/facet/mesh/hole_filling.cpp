// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/hole_filling.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Eigenvalues>

#include "facet/mesh/triangle_index.h"

namespace facet {
namespace {

constexpr std::size_t kMaxBoundary = 200;  // vertices
constexpr double kMinSameDirection =
    0.9;  // cosine between the boundary's plane and the faces around it

/// One side of a face; `from` to `to` runs against the face, so that a hole lies on the left.
struct BorderSide {
  int from = 0, to = 0, face = 0;
};

/// A closed chain of border sides.
using Boundary = std::vector<BorderSide>;

std::uint64_t KeyOf(int from, int to) {
  return (static_cast<std::uint64_t>(from) << 32) | static_cast<std::uint32_t>(to);
}

/// Sorted by `from`.
std::vector<BorderSide> FindBorder(const TriangleMesh& mesh) {
  std::vector<std::uint64_t> sides;
  for (const auto& f : mesh.faces) {
    for (std::size_t i = 0; i < 3; ++i)
      sides.push_back(KeyOf(f[i], f[(i + 1) % 3]));
  }
  std::sort(sides.begin(), sides.end());
  std::vector<BorderSide> border;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) {
      const int from = mesh.faces[f][(i + 1) % 3], to = mesh.faces[f][i];
      if (!std::binary_search(sides.begin(), sides.end(), KeyOf(from, to)))
        border.push_back({from, to, static_cast<int>(f)});
    }
  }
  std::sort(border.begin(), border.end(), [](const BorderSide& a, const BorderSide& b) {
    return KeyOf(a.from, a.to) < KeyOf(b.from, b.to);
  });
  return border;
}

/// Boundaries without a vertex where two borders meet.
std::vector<Boundary> FindBoundaries(const std::vector<BorderSide>& border) {
  const auto first_from = [&](int vertex) {
    return std::lower_bound(
        border.begin(), border.end(), vertex, [](const BorderSide& side, int v) {
          return side.from < v;
        });
  };
  std::vector<char> is_used(border.size(), 0);
  std::vector<Boundary> boundaries;
  for (std::size_t start = 0; start < border.size(); ++start) {
    if (is_used[start] != 0) continue;
    Boundary boundary;
    std::size_t at = start;
    bool is_simple = true;
    while (is_used[at] == 0) {
      is_used[at] = 1;
      boundary.push_back(border[at]);
      const auto next = first_from(border[at].to);
      is_simple = next != border.end() && next->from == border[at].to &&
                  (next + 1 == border.end() || (next + 1)->from != next->from);
      if (!is_simple) break;
      at = static_cast<std::size_t>(next - border.begin());
    }
    if (is_simple && at == start && boundary.size() >= 3) boundaries.push_back(std::move(boundary));
  }
  return boundaries;
}

/// Ear clipping of one hole.
class Patch {
 public:
  Patch(const Boundary& boundary, TriangleMesh& mesh) : mesh_(mesh) {
    for (const BorderSide& side : boundary)
      ring_.push_back(side.from);
  }

  /// Whether the boundary is plane and the faces around it continue that plane.
  bool IsPlane(const Boundary& boundary, double tolerance_m) {
    Vector3d mean = Vector3d::Zero();
    for (int v : ring_)
      mean += mesh_.vertices[v] / static_cast<double>(ring_.size());
    Matrix3d scatter = Matrix3d::Zero();
    for (int v : ring_)
      scatter += (mesh_.vertices[v] - mean) * (mesh_.vertices[v] - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(scatter);
    n_ = solver.eigenvectors().col(0);
    Vector3d around = Vector3d::Zero();
    for (const BorderSide& side : boundary)
      around += FaceNormal(mesh_, side.face) / static_cast<double>(boundary.size());
    if (n_.dot(around) < 0) n_ = -n_;
    const double rms =
        std::sqrt(std::max(solver.eigenvalues()[0], 0.0) / static_cast<double>(ring_.size()));
    return rms <= tolerance_m && n_.dot(around) >= kMinSameDirection && TwiceArea() > 0;
  }

  /// Adds faces; leaves the mesh as it is and returns false when the boundary crosses itself.
  bool Fill(int plane_id) {
    std::vector<std::array<int, 3>> faces;
    while (ring_.size() > 3) {
      const std::size_t ear = FindEar();
      if (ear == ring_.size()) return false;
      const std::size_t before = (ear + ring_.size() - 1) % ring_.size();
      faces.push_back({ring_[before], ring_[ear], ring_[(ear + 1) % ring_.size()]});
      ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    faces.push_back({ring_[0], ring_[1], ring_[2]});
    for (const auto& face : faces) {
      mesh_.faces.push_back(face);
      if (!mesh_.plane_ids.empty()) mesh_.plane_ids.push_back(plane_id);
    }
    return true;
  }

 private:
  double Turn(int a, int b, int c) const {
    const Vector3d& p = mesh_.vertices[a];
    return n_.dot((mesh_.vertices[b] - p).cross(mesh_.vertices[c] - p));
  }

  double TwiceArea() const {
    double sum = 0;
    for (std::size_t i = 1; i + 1 < ring_.size(); ++i)
      sum += Turn(ring_[0], ring_[i], ring_[i + 1]);
    return sum;
  }

  std::size_t FindEar() const {
    const std::size_t size = ring_.size();
    for (std::size_t i = 0; i < size; ++i) {
      const int a = ring_[(i + size - 1) % size], b = ring_[i], c = ring_[(i + 1) % size];
      if (Turn(a, b, c) <= 0) continue;
      const bool is_free = std::none_of(ring_.begin(), ring_.end(), [&](int p) {
        return p != a && p != b && p != c && Turn(a, b, p) >= 0 && Turn(b, c, p) >= 0 &&
               Turn(c, a, p) >= 0;
      });
      if (is_free) return i;
    }
    return size;
  }

  TriangleMesh& mesh_;
  std::vector<int> ring_;
  Vector3d n_ = Vector3d::UnitZ();
};

}  // namespace

int CloseHoles(double max_perimeter_m, double tolerance_m, TriangleMesh& mesh) {
  int num_closed = 0;
  for (const Boundary& boundary : FindBoundaries(FindBorder(mesh))) {
    double perimeter = 0;
    for (const BorderSide& side : boundary)
      perimeter += (mesh.vertices[side.to] - mesh.vertices[side.from]).norm();
    if (boundary.size() > kMaxBoundary || perimeter > max_perimeter_m) continue;
    int plane_id = mesh.plane_ids.empty() ? -1 : mesh.plane_ids[boundary.front().face];
    for (const BorderSide& side : boundary) {
      if (!mesh.plane_ids.empty() && mesh.plane_ids[side.face] != plane_id) plane_id = -1;
    }
    Patch patch(boundary, mesh);
    if (patch.IsPlane(boundary, tolerance_m) && patch.Fill(plane_id)) ++num_closed;
  }
  return num_closed;
}

}  // namespace facet
