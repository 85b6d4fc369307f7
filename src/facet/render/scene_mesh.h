// SPDX-License-Identifier: BSD-2-Clause
// The geometry of a scene: triangles with texture coordinates, grouped into parts.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "facet/base/types.h"

namespace facet {

/// The light on a parallelogram: values on a regular grid that reaches from border to border.
struct LightGrid {
  int columns = 0, rows = 0;  ///< nodes along the first and the second edge, at least two
  Vector3d corner_W = Vector3d::Zero(), u_W = Vector3d::Zero(), v_W = Vector3d::Zero();
  /// Node coordinates of a point from its texture coordinates: (u - first) * scale.
  float first_u = 0, first_v = 0, scale_u = 1, scale_v = 1;
  std::vector<float> light;  ///< row by row; irradiance over pi

  /// Border nodes lie a centimetre inside: at an edge that two surfaces share, rays slip out.
  Vector3d Node(int column, int row) const {
    constexpr double kInset_m = 0.01;
    const auto share = [](int node, int count, double length) {
      const double inset = std::min(0.25, kInset_m / length);
      return std::clamp(static_cast<double>(node) / (count - 1), inset, 1 - inset);
    };
    return corner_W + share(column, columns, u_W.norm()) * u_W + share(row, rows, v_W.norm()) * v_W;
  }
  /// Bilinear; clamped to the grid.
  float At(float u, float v) const {
    const float x = std::clamp((u - first_u) * scale_u, 0.0F, static_cast<float>(columns - 1));
    const float y = std::clamp((v - first_v) * scale_v, 0.0F, static_cast<float>(rows - 1));
    const int left = std::min(static_cast<int>(x), columns - 2);
    const int top = std::min(static_cast<int>(y), rows - 2);
    const float fx = x - static_cast<float>(left), fy = y - static_cast<float>(top);
    const float* a = light.data() + top * columns + left;
    const float* b = a + columns;
    const float upper = a[0] + fx * (a[1] - a[0]), lower = b[0] + fx * (b[1] - b[0]);
    return upper + fy * (lower - upper);
  }
};

/// A connected surface of one material. A planar part lies on n_W . p_W = d_W.
struct ScenePart {
  std::string label;  ///< floor, ceiling, wall, table, box, ...
  int material = 0;   ///< index into MaterialLibrary::materials()
  bool is_planar = false;
  bool is_sheet = false;  ///< open, seen from both sides; other parts bound a solid or the room
  Vector3d n_W = Vector3d::UnitZ();  ///< towards the side from which it is seen
  double d_W = 0;
  double area_m2 = 0;
  LightGrid light;  ///< of planar parts; others have their light at the vertices
};

struct SceneVertex {
  Eigen::Vector3f p_W = Eigen::Vector3f::Zero();
  Eigen::Vector3f n_W = Eigen::Vector3f::UnitZ();  ///< unit, for the light
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();    ///< in units of the texture
  float light = 0;  ///< irradiance over pi: the radiance of a white surface
};

struct SceneTriangle {
  std::array<std::uint32_t, 3> vertices{};  ///< counter-clockwise seen from outside
  std::uint32_t part = 0;
};

struct SceneMesh {
  std::vector<SceneVertex> vertices;
  std::vector<SceneTriangle> triangles;
  std::vector<ScenePart> parts;

  const Eigen::Vector3f& corner(std::size_t triangle, int k) const {
    return vertices[triangles[triangle].vertices[static_cast<std::size_t>(k)]].p_W;
  }
  double TriangleArea(std::size_t triangle) const;
};

}  // namespace facet
