// SPDX-License-Identifier: BSD-2-Clause
// Rough ground, boulders and bushes in a cave: a scene without planes.
#include <algorithm>
#include <cmath>

#include "facet/geometry/so3.h"
#include "facet/render/furniture.h"
#include "facet/render/scene_builder.h"
#include "facet/render/waves.h"

namespace facet {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kCaveRadius = 7.5;
constexpr double kClearance = 0.5;

double DistanceToPath(std::span<const Vector3d> path_W, const Vector3d& p_W) {
  double nearest = 1e9;
  for (const Vector3d& q_W : path_W)
    nearest = std::min(nearest, (q_W - p_W).norm());
  return nearest;
}

void AddThings(ShapeBuilder& builder,
               std::span<const Vector3d> path_W,
               const std::function<double(double, double)>& ground) {
  Rng& rng = builder.rng();
  const MaterialLibrary& m = builder.materials();
  for (int i = 0; i < 90; ++i) {
    const double angle = rng.Uniform(0, kTurn), r = kCaveRadius * std::sqrt(rng.Uniform(0.01, 0.9));
    const double size = rng.Uniform(0.25, 0.85);
    const double x = r * std::cos(angle), y = r * std::sin(angle);
    const bool is_bush = i % 3 == 0;
    const Vector3d p_W(x, y, ground(x, y) + (is_bush ? 0.8 : 0.35) * size);
    if (DistanceToPath(path_W, p_W) < 1.35 * size + kClearance) continue;
    builder.Place(SE3(ExpSO3(rng.Uniform(0, kTurn) * rng.UnitVector()), p_W));
    if (is_bush) {
      builder.AddFoliage({"bush", m.Get("leaf")}, size, 160);
    } else if (i % 3 == 1) {
      builder.AddBlob({"boulder", m.Get("stone"), 0.07}, size, rng.Uniform(0.12, 0.28));
    } else {
      builder.AddBlob({"sack", m.Get(i % 2 ? "fabric" : "soil"), 0.07}, 0.7 * size, 0.15);
    }
  }
}

}  // namespace

SceneModel BuildClutter(const ScenePlan& plan) {
  Rng rng(plan.seed);
  const Waves hills(5, 5, rng), rocks(3, 5, rng);
  ShapeBuilder builder(plan.materials, Rng(rng.Next()));
  const MaterialLibrary& m = plan.materials;
  const auto ground = [&](double x, double y) { return 0.16 * hills.At({x, y, 0}); };

  constexpr double kSide = 2.6 * kCaveRadius;
  builder.AddCurved({"ground", m.Get("soil")}, {150, 150, kSide, kSide}, [&](double s, double t) {
    const double x = kSide * (s - 0.5), y = kSide * (t - 0.5);
    return Vector3d(x, y, ground(x, y));
  });
  // A dome seen from inside: s runs clockwise.
  builder.AddCurved({"cave", m.Get("stone")},
                    {180, 70, kTurn * kCaveRadius, 1.6 * kCaveRadius},
                    [&](double s, double t) {
                      const double azimuth = -kTurn * s;
                      const double elevation = -0.15 + (std::numbers::pi / 2 + 0.15) * t;
                      const Vector3d direction(std::cos(azimuth) * std::cos(elevation),
                                               std::sin(azimuth) * std::cos(elevation),
                                               0.75 * std::sin(elevation));
                      const Vector3d p_W = kCaveRadius * direction;
                      return Vector3d(p_W * (1 + 0.09 * rocks.At(p_W)));
                    });
  AddThings(builder, plan.path_W, ground);

  SceneModel scene;
  scene.lighting.ambient = 0.3;
  for (int i = 0; i < 3; ++i) {
    const double angle = kTurn * (i + rng.Uniform(0.2, 0.8)) / 3;
    const double r = 0.45 * kCaveRadius;
    const Vector3d p_W(r * std::cos(angle), r * std::sin(angle), rng.Uniform(3.2, 4.0));
    scene.lighting.lights.push_back({p_W, 0.3, rng.Uniform(3, 6)});
  }
  scene.mesh = builder.TakeMesh();
  return scene;
}

std::vector<Vector3d> ClutterRoute(std::uint64_t seed) {
  Rng rng(seed + 2);
  std::vector<Vector3d> route_W;
  const double begin = rng.Uniform(0, kTurn);
  for (int i = 0; i < 36; ++i) {
    const double angle = begin + 0.6 * i, r = rng.Uniform(1.8, 3.8);
    route_W.emplace_back(r * std::cos(angle), r * std::sin(angle), rng.Uniform(1.1, 2.1));
  }
  return route_W;
}

}  // namespace facet
