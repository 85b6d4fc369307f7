// SPDX-License-Identifier: BSD-2-Clause
// The geometry of a scene: triangles with texture coordinates, grouped into parts.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "facet/base/types.h"

namespace facet {

/// A connected surface of one material. A planar part lies on n_W . p_W = d_W.
struct ScenePart {
  std::string label;  ///< floor, ceiling, wall, table, box, ...
  int material = 0;   ///< index into MaterialLibrary::materials()
  bool is_planar = false;
  bool is_sheet = false;  ///< open, seen from both sides; other parts bound a solid or the room
  Vector3d n_W = Vector3d::UnitZ();  ///< towards the side from which it is seen
  double d_W = 0;
  double area_m2 = 0;
};

struct SceneVertex {
  Eigen::Vector3f p_W = Eigen::Vector3f::Zero();
  Eigen::Vector3f n_W = Eigen::Vector3f::UnitZ();  ///< unit, for the light
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();    ///< in units of the texture
  float light = 0;  ///< irradiance over pi, that is radiance of a white surface
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
