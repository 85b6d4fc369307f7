// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/shape_builder.h"

#include <algorithm>
#include <cmath>

#include "facet/geometry/so3.h"

namespace facet {

double SceneMesh::TriangleArea(std::size_t triangle) const {
  const Vector3d a = corner(triangle, 0).cast<double>();
  const Vector3d b = corner(triangle, 1).cast<double>(), c = corner(triangle, 2).cast<double>();
  return 0.5 * (b - a).cross(c - a).norm();
}

std::uint32_t ShapeBuilder::AddPart(const Finish& finish) {
  ScenePart part;
  part.label = finish.label;
  part.material = finish.material;
  part.is_sheet = finish.is_sheet;
  mesh_.parts.push_back(part);
  return static_cast<std::uint32_t>(mesh_.parts.size() - 1);
}

std::uint32_t ShapeBuilder::AddVertex(const Vector3d& p_O,
                                      const Vector3d& n_O,
                                      const Vector2d& uv) {
  mesh_.vertices.push_back({(T_WO_ * p_O).cast<float>(),
                            (T_WO_.q * n_O).normalized().cast<float>(),
                            uv.cast<float>(),
                            0});
  return static_cast<std::uint32_t>(mesh_.vertices.size() - 1);
}

void ShapeBuilder::AddTriangle(std::uint32_t part,
                               std::uint32_t a,
                               std::uint32_t b,
                               std::uint32_t c) {
  mesh_.triangles.push_back({{a, b, c}, part});
  mesh_.parts[part].area_m2 += mesh_.TriangleArea(mesh_.triangles.size() - 1);
}

double ShapeBuilder::TileSize(int material) const {
  return materials_.materials()[static_cast<std::size_t>(material)].tile_m;
}

Vector2d ShapeBuilder::RandomOffset(int material) {
  if (TileSize(material) <= 0) return Vector2d::Zero();
  const double u = rng_.Uniform(), v = rng_.Uniform();
  return {u, v};
}

void ShapeBuilder::AddPatch(const Finish& finish,
                            const Vector3d& corner_O,
                            const Vector3d& u_O,
                            const Vector3d& v_O) {
  const std::uint32_t id = AddPart(finish);
  const Vector3d n_O = u_O.cross(v_O).normalized();
  ScenePart& part = mesh_.parts[id];
  part.is_planar = true;
  part.n_W = T_WO_.q * n_O;
  part.d_W = part.n_W.dot(T_WO_ * corner_O);
  const double tile = TileSize(finish.material);
  const Vector2d offset = RandomOffset(finish.material);
  const Vector2d scale =
      tile > 0 ? Vector2d(u_O.norm() / tile, v_O.norm() / tile) : Vector2d(Vector2d::Ones());
  LightGrid& light = part.light;
  light.columns = 1 + std::max(1, static_cast<int>(std::lround(u_O.norm() / finish.cell_m)));
  light.rows = 1 + std::max(1, static_cast<int>(std::lround(v_O.norm() / finish.cell_m)));
  light.corner_W = T_WO_ * corner_O;
  light.u_W = T_WO_.q * u_O;
  light.v_W = T_WO_.q * v_O;
  // Images have their first row at the top, grids at the bottom.
  light.first_u = static_cast<float>(offset.x());
  light.first_v = static_cast<float>(offset.y() + scale.y());
  light.scale_u = static_cast<float>((light.columns - 1) / scale.x());
  light.scale_v = static_cast<float>(-(light.rows - 1) / scale.y());
  const auto vertex = [&](double s, double t) {
    return AddVertex(
        corner_O + s * u_O + t * v_O, n_O, offset + Vector2d(s * scale.x(), (1 - t) * scale.y()));
  };
  const std::uint32_t v00 = vertex(0, 0), v10 = vertex(1, 0), v11 = vertex(1, 1),
                      v01 = vertex(0, 1);
  AddTriangle(id, v00, v10, v11);
  AddTriangle(id, v00, v11, v01);
}

void ShapeBuilder::AddBox(const Finish& finish, const Vector3d& center_O, const Vector3d& size_O) {
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    // Upright sides have their second edge vertical, so that pictures stand upright.
    const int second = axis == 2 ? 1 : 2, first = 3 - axis - second;
    Vector3d n = Vector3d::Zero(), u = Vector3d::Zero(), v = Vector3d::Zero();
    n(axis) = side % 2 ? 1 : -1;
    v(second) = size_O(second);
    u(first) = size_O(first);
    if (u.cross(v).dot(n) < 0) u = -u;
    AddPatch(finish, center_O + 0.5 * size_O(axis) * n - 0.5 * u - 0.5 * v, u, v);
  }
}

void ShapeBuilder::AddCurved(const Finish& finish, const Grid& grid, const SurfaceFunction& p_O) {
  const std::uint32_t id = AddPart(finish);
  const double tile = TileSize(finish.material);
  const Vector2d offset = RandomOffset(finish.material);
  const Vector2d scale = tile > 0 ? Vector2d(grid.length_s_m / tile, grid.length_t_m / tile)
                                  : Vector2d(Vector2d::Ones());
  constexpr double kStep = 1e-3;
  const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
  for (int j = 0; j <= grid.num_t; ++j) {
    for (int i = 0; i <= grid.num_s; ++i) {
      const double s = static_cast<double>(i) / grid.num_s;
      const double t = static_cast<double>(j) / grid.num_t;
      // Poles are avoided: the normal is taken just beside them.
      const double inner = std::clamp(t, 2 * kStep, 1 - 2 * kStep);
      const Vector3d ds = p_O(s + kStep, inner) - p_O(s - kStep, inner);
      const Vector3d dt = p_O(s, inner + kStep) - p_O(s, inner - kStep);
      AddVertex(p_O(s, t), ds.cross(dt), offset + Vector2d(s * scale.x(), (1 - t) * scale.y()));
    }
  }
  const auto at = [&](int i, int j) {
    return first + static_cast<std::uint32_t>(j * (grid.num_s + 1) + i);
  };
  constexpr double kMinArea = 1e-10;
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const Eigen::Vector3f& p = mesh_.vertices[a].p_W;
    const Eigen::Vector3f ab = mesh_.vertices[b].p_W - p, ac = mesh_.vertices[c].p_W - p;
    if (ab.cross(ac).norm() > kMinArea) AddTriangle(id, a, b, c);
  };
  for (int j = 0; j < grid.num_t; ++j) {
    for (int i = 0; i < grid.num_s; ++i) {
      add(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      add(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
}

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// Unit sphere, s around z, t from the south to the north pole.
Vector3d OnSphere(double s, double t) {
  const double elevation = std::numbers::pi * (t - 0.5);
  return {std::cos(kTurn * s) * std::cos(elevation),
          std::sin(kTurn * s) * std::cos(elevation),
          std::sin(elevation)};
}

int Cells(double length_m, double cell_m, int low) {
  return std::max(low, static_cast<int>(std::lround(length_m / cell_m)));
}

}  // namespace

void ShapeBuilder::AddCylinder(const Finish& finish, double radius, double height) {
  const double girth = kTurn * radius;
  const int around = Cells(girth, finish.cell_m, 20);
  AddCurved(
      finish, {around, Cells(height, finish.cell_m, 2), girth, height}, [&](double s, double t) {
        return Vector3d(radius * std::cos(kTurn * s), radius * std::sin(kTurn * s), height * t);
      });
  for (const double side : {-1.0, 1.0}) {
    AddCurved(finish, {around, 2, 2 * radius, 2 * radius}, [&](double s, double t) {
      const double r = radius * (side > 0 ? 1 - t : t);
      return Vector3d(r * std::cos(kTurn * s), r * std::sin(kTurn * s), side > 0 ? height : 0.0);
    });
  }
}

void ShapeBuilder::AddSphere(const Finish& finish, double radius) {
  const int around = Cells(kTurn * radius, finish.cell_m, 32);
  AddCurved(finish,
            {around, around / 2, kTurn * radius, 0.5 * kTurn * radius},
            [&](double s, double t) { return Vector3d(radius * OnSphere(s, t)); });
}

void ShapeBuilder::AddBlob(const Finish& finish, double radius, double roughness) {
  // Sum of waves with random directions: smooth, seamless, all sizes.
  struct Wave {
    Vector3d k;
    double phase, amplitude;
  };
  std::vector<Wave> waves;
  for (int octave = 0; octave < 4; ++octave) {
    const double frequency = 1.6 * std::pow(2.0, octave);
    for (int i = 0; i < 4; ++i) {
      const Vector3d direction = rng_.UnitVector();
      waves.push_back(
          {frequency * direction, rng_.Uniform(0, kTurn), roughness / (2 * std::pow(1.8, octave))});
    }
  }
  const auto p_O = [&](double s, double t) {
    const Vector3d x = OnSphere(s, t);
    double bump = 0;
    for (const Wave& w : waves)
      bump += w.amplitude * std::sin(w.k.dot(x) + w.phase);
    return Vector3d(radius * (1 + bump) * x);
  };
  const int around = Cells(kTurn * radius, finish.cell_m, 40);
  AddCurved(finish, {around, around / 2, kTurn * radius, 0.5 * kTurn * radius}, p_O);
}

void ShapeBuilder::AddFoliage(const Finish& finish, double radius, int count) {
  const std::uint32_t id = AddPart(finish);
  mesh_.parts[id].is_sheet = true;
  for (int i = 0; i < count; ++i) {
    const Vector3d direction = rng_.UnitVector();
    const Vector3d center = radius * std::cbrt(rng_.Uniform(0.1, 1)) * direction;
    const Vector3d n = (direction + 0.7 * rng_.Normal3()).normalized();
    const Matrix<3, 2> basis = TangentBasis(n);
    const double angle = rng_.Uniform(0, kTurn), length = radius * rng_.Uniform(0.1, 0.28);
    const Vector3d u = length * (std::cos(angle) * basis.col(0) + std::sin(angle) * basis.col(1));
    const Vector3d v = 0.4 * n.cross(u);
    const std::array<std::uint32_t, 4> c = {AddVertex(center, n, {0.5, 1}),
                                            AddVertex(center + 0.5 * u - v, n, {0, 0.5}),
                                            AddVertex(center + u, n, {0.5, 0}),
                                            AddVertex(center + 0.5 * u + v, n, {1, 0.5})};
    AddTriangle(id, c[0], c[1], c[2]);
    AddTriangle(id, c[0], c[2], c[3]);
  }
}

void ShapeBuilder::AddTriangles(const Finish& finish,
                                const std::vector<Vector3d>& corners_O,
                                const std::vector<std::array<int, 3>>& triangles) {
  const std::uint32_t id = AddPart(finish);
  const double tile = std::max(TileSize(finish.material), 0.5);
  for (const auto& triangle : triangles) {
    std::array<Vector3d, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = corners_O[static_cast<std::size_t>(triangle[k])];
    const Vector3d n = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    // The texture is projected along the axis nearest to the normal.
    Eigen::Index axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    std::array<std::uint32_t, 3> v{};
    for (std::size_t k = 0; k < 3; ++k)
      v[k] = AddVertex(p[k], n, Vector2d(p[k]((axis + 1) % 3), p[k]((axis + 2) % 3)) / tile);
    AddTriangle(id, v[0], v[1], v[2]);
  }
}

}  // namespace facet
