// SPDX-License-Identifier: BSD-2-Clause
// Finds the triangle of a mesh that is nearest to a point, or on a line, in logarithmic time: a
// tree of axis-aligned boxes.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "facet/mesh/triangle_mesh.h"

namespace facet {

struct SurfacePoint {
  Vector3d p = Vector3d::Zero();
  Vector3d n = Vector3d::Zero();  ///< unit normal of the surface there, sign arbitrary
  double distance = 0;            ///< from the point that was asked for [m]
  int face = -1;                  ///< -1 on a point cloud
};

/// Unit normal of a face by the order of its corners; zero for a face without area.
Vector3d FaceNormal(const TriangleMesh& mesh, int face);
double FaceArea(const TriangleMesh& mesh, int face);

/// Immutable, thread-safe. Faces without area are left out.
class TriangleIndex {
 public:
  explicit TriangleIndex(const TriangleMesh& mesh);

  /// The nearest point of the mesh; empty when nothing is within `max_distance`.
  std::optional<SurfacePoint> Closest(const Vector3d& p, double max_distance) const;

  /// Calls visit(face, t) for every face that the line p + t direction meets with t in
  /// [t_min, t_max], in no particular order, until it returns false.
  void VisitLine(const Vector3d& p,
                 const Vector3d& direction,
                 double t_min,
                 double t_max,
                 const std::function<bool(int face, double t)>& visit) const;

 private:
  struct Triangle {
    Vector3d a, b, c;
    int face;
  };
  struct Node {
    Eigen::AlignedBox3d box;
    int left = -1, right = -1;  // children; a leaf has triangles instead
    int begin = 0, end = 0;
  };

  int Build(int begin, int end);

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace facet
