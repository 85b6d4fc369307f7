// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/lighting.h"

#include <algorithm>
#include <cmath>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"
#include "facet/render/parallel_for.h"

namespace facet {
namespace {

constexpr int kShadowRays = 8;
constexpr int kAmbientRays = 32;

/// Share of the lamp's surface that is seen from p_W.
double VisibleShare(const RayScene& rays, const Light& light, const Vector3d& p_W, Rng& rng) {
  const Matrix<3, 2> basis = TangentBasis((light.p_W - p_W).normalized());
  const double turn = rng.Uniform(0, 2 * std::numbers::pi);
  int num_visible = 0;
  for (int i = 0; i < kShadowRays; ++i) {
    // Evenly spread on a disc that faces the point.
    const double angle = turn + 2.399963 * i, r = std::sqrt((i + 0.5) / kShadowRays);
    const Vector3d target =
        light.p_W +
        light.radius_m * r * (std::cos(angle) * basis.col(0) + std::sin(angle) * basis.col(1));
    num_visible += rays.IsBlocked(p_W, target) ? 0 : 1;
  }
  return static_cast<double>(num_visible) / kShadowRays;
}

/// Share of the hemisphere, weighted by the cosine, that is open up to `reach_m`.
double OpenShare(
    const RayScene& rays, const Vector3d& p_W, const Vector3d& n_W, double reach_m, Rng& rng) {
  const Matrix<3, 2> basis = TangentBasis(n_W);
  const double turn = rng.Uniform(0, 2 * std::numbers::pi);
  int num_open = 0;
  for (int i = 0; i < kAmbientRays; ++i) {
    // A spiral with the golden angle: evenly spread.
    const double angle = turn + 2.399963 * i;
    const double r = std::sqrt((i + 0.5) / kAmbientRays);
    const Vector3d direction = r * std::cos(angle) * basis.col(0) +
                               r * std::sin(angle) * basis.col(1) +
                               std::sqrt(std::max(0.0, 1 - r * r)) * n_W;
    num_open += rays.IsBlocked(p_W, direction, reach_m) ? 0 : 1;
  }
  return static_cast<double>(num_open) / kAmbientRays;
}

/// Where light is computed, and where it goes.
struct LightPoint {
  Vector3d p_W, n_W;
  bool is_sheet = false;
  float* light = nullptr;
};

std::vector<LightPoint> ListPoints(SceneMesh& mesh) {
  std::vector<LightPoint> points;
  for (ScenePart& part : mesh.parts) {
    LightGrid& grid = part.light;
    grid.light.resize(static_cast<std::size_t>(grid.columns * grid.rows));
    for (int row = 0; row < grid.rows; ++row) {
      for (int column = 0; column < grid.columns; ++column) {
        const auto node = static_cast<std::size_t>(row * grid.columns + column);
        points.push_back({grid.Node(column, row), part.n_W, part.is_sheet, &grid.light[node]});
      }
    }
  }
  std::vector<const ScenePart*> part_of_vertex(mesh.vertices.size(), nullptr);
  for (const SceneTriangle& t : mesh.triangles) {
    for (const std::uint32_t v : t.vertices)
      part_of_vertex[v] = &mesh.parts[t.part];
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!part_of_vertex[i] || part_of_vertex[i]->is_planar) continue;
    SceneVertex& vertex = mesh.vertices[i];
    points.push_back({vertex.p_W.cast<double>(),
                      vertex.n_W.cast<double>(),
                      part_of_vertex[i]->is_sheet,
                      &vertex.light});
  }
  return points;
}

double LightAt(const RayScene& rays, const Lighting& lighting, const LightPoint& point, Rng& rng) {
  constexpr double kMinLight = 1e-3;
  const Vector3d p_W = point.p_W + 2e-3 * point.n_W;
  double sum = lighting.ambient * OpenShare(rays, p_W, point.n_W, lighting.occlusion_reach_m, rng);
  for (const Light& light : lighting.lights) {
    const Vector3d to_light = light.p_W - p_W;
    const double distance = to_light.norm();
    double cosine = point.n_W.dot(to_light) / distance;
    if (point.is_sheet) cosine = std::abs(cosine);
    const double full = cosine * Falloff(light, distance);
    if (full > kMinLight) sum += full * VisibleShare(rays, light, p_W, rng);
  }
  return sum;
}

}  // namespace

double Falloff(const Light& light, double distance_m) {
  constexpr double kSoft_m2 = 1;  // light that comes back from the surfaces around the lamp
  return light.power / (distance_m * distance_m + light.radius_m * light.radius_m + kSoft_m2);
}

void BakeLight(const RayScene& rays,
               const Lighting& lighting,
               std::uint64_t seed,
               int num_threads,
               SceneMesh& mesh) {
  constexpr int kBlock = 256;
  const std::vector<LightPoint> points = ListPoints(mesh);
  const int count = static_cast<int>(points.size());
  ParallelFor((count + kBlock - 1) / kBlock, num_threads, [&](int block) {
    for (int i = block * kBlock; i < std::min(count, (block + 1) * kBlock); ++i) {
      Rng rng(seed + static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL);
      const LightPoint& point = points[static_cast<std::size_t>(i)];
      *point.light = static_cast<float>(LightAt(rays, lighting, point, rng));
    }
  });
}

}  // namespace facet
