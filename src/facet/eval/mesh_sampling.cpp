// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/mesh_sampling.h"

#include <algorithm>
#include <cmath>

#include "facet/base/random.h"
#include "facet/mesh/triangle_index.h"

namespace facet {
namespace {

Vector3d RandomPointOnFace(const TriangleMesh& mesh, int face, Rng& rng) {
  const auto& [i, j, k] = mesh.faces[face];
  const double root = std::sqrt(rng.Uniform());
  const double v = root * rng.Uniform();
  return (1 - root) * mesh.vertices[i] + (root - v) * mesh.vertices[j] + v * mesh.vertices[k];
}

}  // namespace

std::vector<MeshSample> SampleMesh(const TriangleMesh& mesh,
                                   double samples_per_m2,
                                   std::size_t max_samples,
                                   std::uint64_t seed) {
  std::vector<MeshSample> samples;
  const double area = TotalArea(mesh);
  if (!(area > 0)) return samples;
  const double wanted =
      std::min(std::ceil(area * samples_per_m2), static_cast<double>(max_samples));
  const double share = area / std::max(1.0, wanted);
  samples.reserve(static_cast<std::size_t>(wanted) + 1);
  Rng rng(seed);
  double next = 0.5 * share;  // place of the next sample along the summed area
  double passed = 0;
  for (int f = 0; f < static_cast<int>(mesh.faces.size()); ++f) {
    passed += FaceArea(mesh, f);
    for (; next < passed; next += share)
      samples.push_back({RandomPointOnFace(mesh, f, rng), f});
  }
  return samples;
}

std::vector<Vector3d> Positions(const std::vector<MeshSample>& samples) {
  std::vector<Vector3d> positions;
  positions.reserve(samples.size());
  for (const MeshSample& sample : samples)
    positions.push_back(sample.p);
  return positions;
}

double TotalArea(const TriangleMesh& mesh) {
  double area = 0;
  for (int f = 0; f < static_cast<int>(mesh.faces.size()); ++f)
    area += FaceArea(mesh, f);
  return area;
}

}  // namespace facet
