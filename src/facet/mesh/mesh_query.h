// SPDX-License-Identifier: BSD-2-Clause
// The questions of a planner: what is ahead, how high am I, how close is the nearest surface?
#pragma once

#include <optional>

#include "facet/mesh/triangle_index.h"
#include "facet/mesh/triangle_mesh.h"

namespace facet {

/// A place on the mesh that answers a question.
struct SurfaceHit {
  Vector3d p_W = Vector3d::Zero();
  double distance_m = 0;  ///< from the point that was asked for
  int face = -1;
};

/// Immutable, thread-safe; logarithmic time per question. Copies what it needs of the mesh:
///
///   const MeshQuery query(output.mesh->mesh);
///   if (auto hit = query.FirstAlongRay(p_W, v_W, 5.0)) Brake(hit->distance_m);
///
/// Questions with values that are not finite have no answer.
class MeshQuery {
 public:
  /// The mesh is in W, with z up.
  explicit MeshQuery(const TriangleMesh& mesh) : index_(mesh) {}

  /// The first face along a ray, from either side. `direction_W` need not have unit length; empty
  /// for zero.
  std::optional<SurfaceHit> FirstAlongRay(const Vector3d& origin_W,
                                          const Vector3d& direction_W,
                                          double max_distance_m) const;

  /// The first face straight below; its distance is the height above it.
  std::optional<SurfaceHit> Below(const Vector3d& p_W, double max_height_m) const;

  /// The nearest point of the mesh.
  std::optional<SurfaceHit> Nearest(const Vector3d& p_W, double max_distance_m) const;

 private:
  TriangleIndex index_;
};

}  // namespace facet
