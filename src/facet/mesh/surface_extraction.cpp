// SPDX-License-Identifier: BSD-2-Clause
// Surface nets (Gibson, MICCAI 1998): one vertex in each cell of the grid that the surface passes
// through, one quad around each side of a cell that it crosses.
#include <algorithm>
#include <cmath>

#include "facet/mesh/hole_filling.h"
#include "facet/mesh/mesh_cleanup.h"
#include "facet/mesh/surface_map.h"
#include "facet/mesh/vertex_normals.h"

namespace facet {
namespace {

using Voxel = SurfaceMap::Voxel;

// Weight below which a voxel is not part of the surface. A face whose depth is known to 2 cm adds
// 1, to 14 cm 0.02.
constexpr double kMinWeight = 0.02;

CubeIndex Offset(const CubeIndex& c, int dx, int dy, int dz) {
  return {c.x + dx, c.y + dy, c.z + dz};
}

class Extraction {
 public:
  explicit Extraction(const SurfaceMap& map) : map_(map) {}

  TriangleMesh Run() {
    for (const SurfaceMap::Block& block : map_.blocks())
      VisitKnown(block, [this](const CubeIndex& c) { AddVertex(c); });
    // A cell reaches beyond its block on the upper side only, so no other cell has a vertex except
    // those whose lowest corner lies in no block; they lack that corner and have none.
    for (const SurfaceMap::Block& block : map_.blocks())
      VisitKnown(block, [this](const CubeIndex& c) { AddQuads(c); });
    CleanUp(mesh_);
    constexpr double kBoundaryTolerance = 0.25;  // voxels
    CloseHoles(map_.options().max_hole_m, kBoundaryTolerance * map_.options().voxel_m, mesh_);
    SetVertexNormals(mesh_);
    return std::move(mesh_);
  }

  /// Corners of the blocks of one part; cells reach one corner below it.
  TriangleMesh RunPart(const CubeIndex& part) {
    constexpr int n = SurfaceMap::kBlockSide, m = kPartSide;
    const CubeIndex low{part.x * m * n, part.y * m * n, part.z * m * n};
    const auto is_in = [&](const CubeIndex& c, int below) {
      const auto within = [&](int x, int begin) { return x >= begin - below && x < begin + m * n; };
      return within(c.x, low.x) && within(c.y, low.y) && within(c.z, low.z);
    };
    std::vector<const SurfaceMap::Block*> blocks;
    for (int i = 0; i < (m + 1) * (m + 1) * (m + 1); ++i) {
      const int x = i % (m + 1) - 1, y = i / (m + 1) % (m + 1) - 1, z = i / (m + 1) / (m + 1) - 1;
      const auto* block = map_.FindBlock({part.x * m + x, part.y * m + y, part.z * m + z});
      if (block != nullptr) blocks.push_back(block);
    }
    for (const SurfaceMap::Block* block : blocks) {
      VisitKnown(*block, [&](const CubeIndex& c) {
        if (is_in(c, 1)) AddVertex(c);
      });
    }
    for (const SurfaceMap::Block* block : blocks) {
      VisitKnown(*block, [&](const CubeIndex& c) {
        if (is_in(c, 0)) AddQuads(c);
      });
    }
    DropUnused();
    SetVertexNormals(mesh_);
    return std::move(mesh_);
  }

 private:
  /// Vertices without a face.
  void DropUnused() {
    std::vector<int> number(mesh_.vertices.size(), -1);
    TriangleMesh used;
    for (auto& face : mesh_.faces) {
      for (int& corner : face) {
        if (number[corner] < 0) {
          number[corner] = static_cast<int>(used.vertices.size());
          used.vertices.push_back(mesh_.vertices[corner]);
          used.colours.push_back(mesh_.colours[corner]);
        }
        corner = number[corner];
      }
    }
    mesh_.vertices = std::move(used.vertices);
    mesh_.colours = std::move(used.colours);
  }

  template <class Visit>
  static void VisitCorners(const SurfaceMap::Block& block, const Visit& visit) {
    constexpr int n = SurfaceMap::kBlockSide;
    for (int z = 0; z < n; ++z) {
      for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x)
          visit({block.index.x * n + x, block.index.y * n + y, block.index.z * n + z});
      }
    }
  }

  /// The corners at which something is known: few of a block, and the others have no vertex.
  template <class Visit>
  static void VisitKnown(const SurfaceMap::Block& block, const Visit& visit) {
    auto voxel = block.voxels.begin();
    VisitCorners(block, [&](const CubeIndex& c) {
      if ((voxel++)->weight >= kMinWeight) visit(c);
    });
  }

  const Voxel* Known(const CubeIndex& c) const {
    const Voxel* voxel = map_.Find(c);
    return voxel != nullptr && voxel->weight >= kMinWeight ? voxel : nullptr;
  }

  // Along one side of a cell a distance changes by at most its length; anything more is the border
  // between two surfaces that know nothing of each other.
  bool Crosses(const Voxel& a, const Voxel& b) const {
    return (a.distance >= 0) != (b.distance >= 0) &&
           std::abs(a.distance - b.distance) < 1.5 * map_.options().voxel_m;
  }

  void AddVertex(const CubeIndex& cell) {
    std::array<const Voxel*, 8> corners;
    for (int i = 0; i < 8; ++i) {
      corners[i] = Known(Offset(cell, i & 1, (i >> 1) & 1, (i >> 2) & 1));
      if (corners[i] == nullptr) return;
    }
    Vector3d sum = Vector3d::Zero();
    double intensity = 0;
    int count = 0, plane_id = -1;
    for (int i = 0; i < 8; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        const int j = i | (1 << axis);
        if (j == i || !Crosses(*corners[i], *corners[j])) continue;
        const double t = corners[i]->distance / (corners[i]->distance - corners[j]->distance);
        Vector3d p((i & 1), (i >> 1) & 1, (i >> 2) & 1);
        p[axis] += t;
        sum += p;
        intensity += (1 - t) * corners[i]->intensity + t * corners[j]->intensity;
        plane_id = std::max(plane_id, corners[i]->plane_id);
        ++count;
      }
    }
    if (count == 0) return;
    vertex_of_cell_.Add(cell, static_cast<int>(mesh_.vertices.size()));
    mesh_.vertices.push_back(map_.Position(cell) + map_.options().voxel_m * sum / count);
    const auto grey = static_cast<std::uint8_t>(std::clamp(intensity / count, 0.0, 255.0));
    mesh_.colours.push_back({grey, grey, grey});
    plane_of_vertex_.push_back(plane_id);
  }

  void AddQuads(const CubeIndex& c) {
    const Voxel* here = Known(c);
    if (here == nullptr) return;
    for (int axis = 0; axis < 3; ++axis) {
      const auto along = [](int a, int d) { return a == d ? 1 : 0; };
      const Voxel* there = Known(Offset(c, along(0, axis), along(1, axis), along(2, axis)));
      if (there == nullptr || !Crosses(*here, *there)) continue;
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto cell = [&](int du, int dv) {
        return vertex_of_cell_.Find(Offset(c,
                                           -(du * along(0, u) + dv * along(0, v)),
                                           -(du * along(1, u) + dv * along(1, v)),
                                           -(du * along(2, u) + dv * along(2, v))));
      };
      const int a = cell(0, 0), b = cell(1, 0), d = cell(1, 1), e = cell(0, 1);
      if (std::min({a, b, d, e}) == CubeMap::kNone) continue;
      if (there->distance > here->distance) {  // the free side is upwards
        AddQuad({a, b, d, e});
      } else {
        AddQuad({a, e, d, b});
      }
    }
  }

  // Cut along the shorter diagonal.
  void AddQuad(const std::array<int, 4>& q) {
    const auto length = [&](int i, int j) {
      return (mesh_.vertices[q[i]] - mesh_.vertices[q[j]]).squaredNorm();
    };
    const int s = length(0, 2) <= length(1, 3) ? 0 : 1;
    AddFace({q[s], q[s + 1], q[(s + 2) % 4]});
    AddFace({q[s], q[(s + 2) % 4], q[(s + 3) % 4]});
  }

  void AddFace(const std::array<int, 3>& face) {
    mesh_.faces.push_back(face);
    // On a plane with all its corners, otherwise on none.
    const int id = plane_of_vertex_[face[0]];
    const bool same = plane_of_vertex_[face[1]] == id && plane_of_vertex_[face[2]] == id;
    mesh_.plane_ids.push_back(same ? id : -1);
  }

  const SurfaceMap& map_;
  CubeMap vertex_of_cell_;
  std::vector<int> plane_of_vertex_;
  TriangleMesh mesh_;
};

}  // namespace

CubeIndex PartOf(const CubeIndex& block) {
  const auto part = [](std::int32_t x) { return x >= 0 ? x / kPartSide : (x + 1) / kPartSide - 1; };
  return {part(block.x), part(block.y), part(block.z)};
}

TriangleMesh ExtractPart(const SurfaceMap& map, const CubeIndex& part) {
  return Extraction(map).RunPart(part);
}

TriangleMesh ExtractSurface(const SurfaceMap& map) {
  return Extraction(map).Run();
}

}  // namespace facet
