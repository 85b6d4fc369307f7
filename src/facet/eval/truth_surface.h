// SPDX-License-Identifier: BSD-2-Clause
// The true surfaces of a scene, from a mesh or from a point cloud (a laser scan): how far is a
// point from them?
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "facet/mesh/triangle_index.h"

namespace facet {

/// Two real kinds: triangles, and points with the surface between them.
///
/// A point cloud stands for a surface: each point carries a disc in the plane of its neighbours
/// whose radius is its distance to the sixth of them, and distances are to the nearest disc.
/// Distances to bare points would have a floor of half the spacing of the points (1.6 cm at 1000
/// points per m2). Where the neighbours lie on no plane the point stands for itself.
class TruthSurface {
 public:
  virtual ~TruthSurface() = default;

  /// The nearest point of the surface, however far.
  virtual SurfacePoint Closest(const Vector3d& p_G) const = 0;

  /// Points spread over the surface: those of the cloud, or 1000 per m2 of the mesh.
  virtual const std::vector<Vector3d>& points() const = 0;

  /// The triangles; null for a point cloud.
  virtual const TriangleIndex* triangles() const { return nullptr; }
};

/// A mesh if it has faces, otherwise a cloud. CHECKs that it has vertices.
std::unique_ptr<TruthSurface> MakeTruthSurface(TriangleMesh truth);

}  // namespace facet
