// SPDX-License-Identifier: BSD-2-Clause
// The map of the whole run: the surfaces that left the horizon, at the places where the poses of
// their keyframes put them when these became final. Faces are merged into a grid of signed
// distances (Curless & Levoy, SIGGRAPH 1996) that exists near surfaces only: where the camera
// returns, new and old faces become one surface, and memory is bounded by the mapped area. What
// stands between a face and the camera that saw it is carved away.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "facet/mesh/cube_map.h"
#include "facet/mesh/horizon_mesh.h"
#include "facet/mesh/mesh_options.h"
#include "facet/mesh/triangle_mesh.h"

namespace facet {

struct FlatFace;

/// What a map takes up.
struct MapMemory {
  double used_mb = 0;
  bool is_full = false;  ///< surfaces were left out because the map may not grow
};

/// Not thread-safe. The same faces in the same order give the same map.
class SurfaceMap {
 public:
  static constexpr int kBlockSide = 8;  ///< voxels along the side of a block

  /// A corner of the grid.
  struct Voxel {
    float distance = 0;  ///< to the surface [m], positive on the side of the camera
    float weight = 0;    ///< 0: nothing known
    float intensity = 0;
    std::int32_t plane_id = -1;
  };
  struct Block {
    CubeIndex index;
    std::array<Voxel, kBlockSide * kBlockSide * kBlockSide> voxels;
  };

  explicit SurfaceMap(const SurfaceMapOptions& options) : options_(options) {}

  /// Merges a face, as far as options().max_memory_mb allows, and weakens what its camera has seen
  /// it through. Faces that are not finite, or whose back their camera sees, are
  /// ignored.
  void Add(const ExpiredFace& face);

  /// Null where nothing is known.
  const Voxel* Find(const CubeIndex& corner) const;
  Vector3d Position(const CubeIndex& corner) const {
    return options_.voxel_m * Vector3d(corner.x, corner.y, corner.z);
  }

  /// Null where there is none.
  const Block* FindBlock(const CubeIndex& index) const;

  /// Copies of the blocks that have changed since they were last taken, for whoever follows the
  /// map; at most this many, the others the next time.
  std::vector<Block> TakeChanged(std::size_t max_blocks);

  /// Adds a block of another map, or replaces the one in its place: so one map follows another.
  void SetBlock(const Block& block);

  const SurfaceMapOptions& options() const { return options_; }
  const std::deque<Block>& blocks() const { return blocks_; }
  MapMemory memory() const { return {MegabytesOf(blocks_.size()), is_full_}; }

 private:
  /// What all columns of a face have in common.
  struct Columns {
    int axis = 0;    // along them
    int stride = 1;  // from one voxel to the next
    float step = 0;  // from one corner to the next [m]
    int plane_id = -1;
  };
  /// The corners first, first + 1, ... along one axis of the grid, and what a face says about them.
  struct Column {
    std::array<std::int32_t, 3> first{};
    std::int32_t end = 0;  // behind the last one, along the axis
    float distance = 0;    // of the first corner to the face [m]
    float weight = 0, intensity = 0;
  };
  /// The part of a column that lies in one block.
  struct Run {
    Voxel* first = nullptr;
    int count = 0;
    float distance = 0, weight = 0, intensity = 0;
  };
  void SplitColumn(const Columns& all, const Column& column);
  static void Merge(const Columns& all, const Run& run);
  static double MegabytesOf(std::size_t blocks) {
    return 1e-6 * static_cast<double>(blocks * sizeof(Block));
  }
  /// Marks corners in one block, along an axis.
  void Touch(int block, const CubeIndex& first, int axis, int count);
  struct KnownBlock;
  /// Whether a block is there.
  KnownBlock& Know(const CubeIndex& index);
  /// CubeMap::kNone where a new block would be more than the map may have.
  int BlockAt(const CubeIndex& index);
  int AddBlock(const CubeIndex& index);
  void FollowColumns(const ExpiredFace& face,
                     const std::array<Vector3d, 3>& p,
                     const FlatFace& flat,
                     const Columns& all);
  void FollowSights(const Vector3d& eye_W, const std::array<Vector3d, 3>& p_W, const Vector3d& n_W);
  int RowsOfSights(double area_m2);
  void FollowSight(const Vector3d& from_W, const Vector3d& to_W, double begin_m);

  SurfaceMapOptions options_;
  std::deque<Block> blocks_;  // in the order in which they were needed; never moved
  // One bit for each of the 4 x 4 x 4 cubes of voxels of a block: whether it may hold something.
  // Sight lines pass through much that is empty, and these bits fit the processor's cache.
  std::vector<std::uint64_t> touched_;
  std::vector<char> has_changed_;  // by block, since the last TakeChanged
  CubeMap index_;                  // of blocks_
  // Columns and sight lines come back to the same blocks again and again: what index_ says of the
  // last ones. Neighbours never take each other's place.
  static constexpr int kKnownSide = 4;
  struct KnownBlock {
    CubeIndex index;
    int block = CubeMap::kNone;
  };
  std::array<KnownBlock, kKnownSide * kKnownSide * kKnownSide> known_;
  bool is_full_ = false;
  double shared_sight_ = 0;  // the part of a sight line that small faces have added up to
  // Storage that Add keeps between calls.
  std::vector<Run> runs_;
  std::vector<Voxel*> seen_through_;
};

/// The surface of the map as triangles of about the size of a voxel, with normals, colours and
/// plane ids; holes are closed as the options say.
TriangleMesh ExtractSurface(const SurfaceMap& map);

/// Blocks along the side of a part.
inline constexpr int kPartSide = 4;

/// The part that a block belongs to.
CubeIndex PartOf(const CubeIndex& block);

/// The triangles that begin in one part of the map, at once where ExtractSurface takes its time:
/// holes are left open, and what hangs on nothing stays. All parts together cover the surface.
TriangleMesh ExtractPart(const SurfaceMap& map, const CubeIndex& part);

/// The map as a run that ends now would leave it: with what is still in the horizon.
SurfaceMap WithHorizon(SurfaceMap map, HorizonMesh horizon);

}  // namespace facet
