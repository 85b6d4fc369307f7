// SPDX-License-Identifier: BSD-2-Clause
// Points spread uniformly over the area of a mesh: what the accuracy of a mesh is measured on.
#pragma once

#include <cstdint>
#include <vector>

#include "facet/mesh/triangle_mesh.h"

namespace facet {

inline constexpr double kSamplesPerSquareMetre = 1000;

struct MeshSample {
  Vector3d p = Vector3d::Zero();
  int face = -1;
};

/// Stratified by area and the same for the same mesh and seed: sample k lies in the k-th of equal
/// shares of the area, in order of faces, at a random place in its face. At most `max_samples`;
/// a larger mesh is sampled more thinly. At least one if the mesh has any area.
std::vector<MeshSample> SampleMesh(const TriangleMesh& mesh,
                                   double samples_per_m2,
                                   std::size_t max_samples = 5'000'000,
                                   std::uint64_t seed = 1);

std::vector<Vector3d> Positions(const std::vector<MeshSample>& samples);

/// [m^2]
double TotalArea(const TriangleMesh& mesh);

}  // namespace facet
