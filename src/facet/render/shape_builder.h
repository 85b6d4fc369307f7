// SPDX-License-Identifier: BSD-2-Clause
// Adds simple shapes to a mesh. Shapes are given in a local frame O that is placed with T_WO.
#pragma once

#include <functional>
#include <string>

#include "facet/base/random.h"
#include "facet/geometry/se3.h"
#include "facet/render/materials.h"
#include "facet/render/scene_mesh.h"

namespace facet {

/// Not thread-safe. Texture coordinates begin at a random place, so that two boards of the same
/// wood differ.
class ShapeBuilder {
 public:
  ShapeBuilder(const MaterialLibrary& materials, Rng rng) : materials_(materials), rng_(rng) {}

  void Place(const SE3& T_WO) { T_WO_ = T_WO; }
  Rng& rng() { return rng_; }
  const MaterialLibrary& materials() const { return materials_; }
  SceneMesh TakeMesh() { return std::move(mesh_); }
  std::size_t num_triangles() const { return mesh_.triangles.size(); }

  struct Finish {
    std::string label;
    int material = 0;
    double cell_m = 0.12;  ///< distance of the points where light is computed
    bool is_sheet = false;
  };

  /// The parallelogram corner_O + [0,1] u_O + [0,1] v_O, seen from the side of u x v.
  void AddPatch(const Finish& finish,
                const Vector3d& corner_O,
                const Vector3d& u_O,
                const Vector3d& v_O);

  /// A cuboid around center_O.
  void AddBox(const Finish& finish, const Vector3d& center_O, const Vector3d& size_O);

  /// A surface p_O(s, t), s and t in [0, 1], as num_s x num_t quadrilaterals; its normals are
  /// those of dp/ds x dp/dt. `closed_s`: s = 0 and s = 1 are the same line.
  using SurfaceFunction = std::function<Vector3d(double s, double t)>;
  struct Grid {
    int num_s = 16, num_t = 16;
    double length_s_m = 1, length_t_m = 1;  ///< for the texture
  };
  void AddCurved(const Finish& finish, const Grid& grid, const SurfaceFunction& p_O);

  /// Along the local z axis from z = 0, with caps.
  void AddCylinder(const Finish& finish, double radius, double height);
  void AddSphere(const Finish& finish, double radius);
  /// A sphere with bumps of all sizes, `roughness` (0..0.5) of its radius.
  void AddBlob(const Finish& finish, double radius, double roughness);
  /// `count` small leaves at random inside a sphere.
  void AddFoliage(const Finish& finish, double radius, int count);
  /// Triangles from a file: corners in O.
  void AddTriangles(const Finish& finish,
                    const std::vector<Vector3d>& corners_O,
                    const std::vector<std::array<int, 3>>& triangles);

 private:
  std::uint32_t AddPart(const Finish& finish);
  std::uint32_t AddVertex(const Vector3d& p_O, const Vector3d& n_O, const Vector2d& uv);
  void AddTriangle(std::uint32_t part, std::uint32_t a, std::uint32_t b, std::uint32_t c);
  double TileSize(int material) const;
  Vector2d RandomOffset(int material);

  const MaterialLibrary& materials_;
  Rng rng_;
  SE3 T_WO_;
  SceneMesh mesh_;
};

}  // namespace facet
