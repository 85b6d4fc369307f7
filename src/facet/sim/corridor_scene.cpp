// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/corridor_scene.h"

#include <algorithm>
#include <cmath>

#include "facet/geometry/so3.h"

namespace facet {

namespace {

constexpr double kEyeHeight_m = 1.4;
constexpr double kGap_m = 0.2;  // between cupboards, and to the edges of a wall

Surface MakeRectangle(const Vector3d& center_W,
                      const Vector3d& u_W,
                      const Vector3d& v_W,
                      double half_u,
                      double half_v) {
  Surface out;
  out.center_W = center_W;
  out.u_W = u_W;
  out.v_W = v_W;
  out.n_W = u_W.cross(v_W);
  out.half_u = half_u;
  out.half_v = half_v;
  return out;
}

/// Collects surfaces and numbers them.
class Corridor {
 public:
  explicit Corridor(const CorridorOptions& options)
      : options_(options), R_(ExpSO3(Vector3d(0, 0, options.heading_rad)).toRotationMatrix()) {
    const double out_x = 0.5 * (options.length_m + options.width_m);
    const double out_y = 0.5 * (options.depth_m + options.width_m);
    AddLevel(0, 1, out_x, out_y);
    AddLevel(options.height_m, -1, out_x, out_y);
    AddWalls(out_x, out_y, -1);
    AddWalls(out_x - options.width_m, out_y - options.width_m, 1);
  }

  /// One more cupboard, unless no free place is found.
  void AddCupboard(Rng& rng) {
    constexpr int kAttempts = 20;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      Wall& wall = walls_[static_cast<std::size_t>(rng.Index(static_cast<int>(walls_.size())))];
      const double half_u = rng.Uniform(0.4, 1.0), half_v = rng.Uniform(0.4, 0.9);
      const double bottom = rng.Uniform(0, 0.6), share = rng.Uniform(-1, 1);
      const double reach = wall.half_free - half_u - kGap_m;
      if (reach < 0) continue;
      const double at = share * reach;
      const bool is_free = std::all_of(wall.taken.begin(), wall.taken.end(), [&](const auto& t) {
        return std::abs(t.first - at) > t.second + half_u + kGap_m;
      });
      if (!is_free) continue;
      wall.taken.emplace_back(at, half_u);
      AddBox(surfaces_[wall.surface], at, bottom + half_v, half_u, half_v);
      return;
    }
  }

  std::vector<Surface> Take() { return std::move(surfaces_); }

 private:
  struct Wall {
    std::size_t surface = 0;
    double half_free = 0;                          // of its length, away from the corners
    std::vector<std::pair<double, double>> taken;  // middle and half width
  };

  void Add(Surface surface) {
    surface.id = PlaneId{static_cast<std::int64_t>(surfaces_.size())};
    surfaces_.push_back(surface);
  }

  void AddLevel(double z, double up, double half_x, double half_y) {
    const Vector3d x_W = R_.col(0), y_W = up * R_.col(1);
    Add(MakeRectangle({0, 0, z}, x_W, y_W, half_x, half_y));
  }

  /// Four walls around a rectangle, seen from outside (1) or inside (-1).
  void AddWalls(double half_x, double half_y, double side) {
    for (int k = 0; k < 4; ++k) {
      const double sign = k % 2 == 0 ? 1 : -1;
      const bool is_long = k < 2;
      const Vector3d out_W = sign * (is_long ? R_.col(1) : R_.col(0));
      const double distance = is_long ? half_y : half_x, half = is_long ? half_x : half_y;
      const Vector3d n_W = side * out_W, up_W = Vector3d::UnitZ();
      const double half_height = 0.5 * options_.height_m;
      walls_.push_back({surfaces_.size(), side > 0 ? half : half - options_.width_m, {}});
      Add(MakeRectangle(
          distance * out_W + half_height * up_W, up_W.cross(n_W), up_W, half, half_height));
    }
  }

  /// Front, top, bottom and two sides of a cuboid on a wall. A copy of the wall: surfaces_ grows.
  void AddBox(Surface wall, double at, double height, double half_u, double half_v) {
    const double half_depth = 0.5 * options_.cupboard_depth_m;
    const Vector3d &u = wall.u_W, &v = wall.v_W, &n = wall.n_W;
    const Vector3d c = wall.center_W + at * u + (height - wall.half_v) * v + half_depth * n;
    Add(MakeRectangle(c + half_depth * n, u, v, half_u, half_v));
    Add(MakeRectangle(c + half_u * u, v, n, half_v, half_depth));
    Add(MakeRectangle(c - half_u * u, n, v, half_depth, half_v));
    Add(MakeRectangle(c + half_v * v, n, u, half_depth, half_u));
    Add(MakeRectangle(c - half_v * v, u, n, half_u, half_depth));
  }

  CorridorOptions options_;
  Matrix3d R_;
  std::vector<Surface> surfaces_;
  std::vector<Wall> walls_;
};

}  // namespace

std::vector<Surface> MakeCorridor(const CorridorOptions& options, Rng& rng) {
  Corridor corridor(options);
  for (int i = 0; i < options.num_cupboards; ++i)
    corridor.AddCupboard(rng);
  return corridor.Take();
}

std::vector<Vector3d> CorridorWalk(const CorridorOptions& options, int laps) {
  const Matrix3d R = ExpSO3(Vector3d(0, 0, options.heading_rad)).toRotationMatrix();
  const double x = 0.5 * options.length_m, y = 0.5 * options.depth_m;
  std::vector<Vector3d> route_W = {R * Vector3d(0, -y, kEyeHeight_m)};
  for (int lap = 0; lap < laps; ++lap) {
    for (const Vector2d& corner :
         {Vector2d(x, -y), Vector2d(x, y), Vector2d(-x, y), Vector2d(-x, -y)})
      route_W.push_back(R * Vector3d(corner.x(), corner.y(), kEyeHeight_m));
  }
  route_W.push_back(R * Vector3d(0, -y, kEyeHeight_m));
  return route_W;
}

}  // namespace facet
