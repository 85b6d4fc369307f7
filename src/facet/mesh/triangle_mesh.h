// SPDX-License-Identifier: BSD-2-Clause
// A triangle mesh as plain data: what mesh.ply and map.ply hold, and what the evaluation samples.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "facet/base/types.h"

namespace facet {

/// Vertices in one frame [m] and faces over their indices, counter-clockwise seen from outside.
/// Without faces it is a point cloud. The optional parts are empty or complete.
struct TriangleMesh {
  std::vector<Vector3d> vertices;
  std::vector<Vector3d> normals;                     ///< optional, one per vertex, unit
  std::vector<std::array<std::uint8_t, 3>> colours;  ///< optional, red green blue per vertex
  std::vector<float>
      sigma_m;  ///< optional, one per vertex: 1-sigma of its distance from the camera
  std::vector<std::array<int, 3>> faces;
  std::vector<int> plane_ids;  ///< optional, one per face; -1: on no plane
};

}  // namespace facet
