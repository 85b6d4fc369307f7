// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/lighting.h"

#include <algorithm>
#include <cmath>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"
#include "facet/render/parallel_for.h"

namespace facet {
namespace {

constexpr int kShadowRays = 12;
constexpr int kAmbientRays = 48;

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

}  // namespace

double Falloff(const Light& light, double distance_m) {
  return light.power / (distance_m * distance_m + light.radius_m * light.radius_m);
}

void BakeLight(const RayScene& rays,
               const Lighting& lighting,
               std::uint64_t seed,
               int num_threads,
               SceneMesh& mesh) {
  std::vector<bool> is_sheet(mesh.vertices.size(), false);
  for (const SceneTriangle& t : mesh.triangles) {
    for (const std::uint32_t v : t.vertices)
      is_sheet[v] = mesh.parts[t.part].is_sheet;
  }
  constexpr int kBlock = 256;
  const int num_vertices = static_cast<int>(mesh.vertices.size());
  ParallelFor((num_vertices + kBlock - 1) / kBlock, num_threads, [&](int block) {
    for (int i = block * kBlock; i < std::min(num_vertices, (block + 1) * kBlock); ++i) {
      Rng rng(seed + static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL);
      SceneVertex& vertex = mesh.vertices[static_cast<std::size_t>(i)];
      const Vector3d n_W = vertex.n_W.cast<double>();
      const Vector3d p_W = vertex.p_W.cast<double>() + 2e-3 * n_W;
      double sum = lighting.ambient * OpenShare(rays, p_W, n_W, lighting.occlusion_reach_m, rng);
      for (const Light& light : lighting.lights) {
        const Vector3d to_light = light.p_W - p_W;
        const double distance = to_light.norm();
        double cosine = n_W.dot(to_light) / distance;
        if (is_sheet[static_cast<std::size_t>(i)]) cosine = std::abs(cosine);
        if (cosine <= 0) continue;
        sum += cosine * Falloff(light, distance) * VisibleShare(rays, light, p_W, rng);
      }
      vertex.light = static_cast<float>(sum);
    }
  });
}

}  // namespace facet
