// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/surface_map.h"

#include <algorithm>
#include <cmath>

#include "facet/mesh/flat_face.h"
#include "facet/mesh/grid_line.h"

namespace facet {
namespace {

// Surfaces nearer than this merge: with less than one voxel corners of the grid would know nothing.
constexpr double kTruncationVoxels = 2;

constexpr float kMaxWeight = 50;
// The weight of a face is 1 where the depth is this uncertain [m].
constexpr double kUnitSigma_m = 0.025;
constexpr double kMinFaceWeight = 1e-3, kMaxFaceWeight = 4;

// A sight line for so much surface, and the distance of the places that are looked at along it.
constexpr double kSightArea = 6, kSightStepVoxels = 2;  // voxels^2, voxels
// Rows of sight lines to one face, and the part of them that is followed.
constexpr int kMaxSightRows = 30;
constexpr double kMinSight_m = 0.1, kMaxSight_m = 20;

// std::floor is a call where SSE2 is the most.
std::int32_t FloorOf(double x) {
  const auto towards_zero = static_cast<std::int32_t>(x);
  return towards_zero - (x < towards_zero ? 1 : 0);
}

// Shifts round down, below zero as well.
CubeIndex BlockOf(const CubeIndex& c) {
  constexpr int kShift = 3;
  static_assert(1 << kShift == SurfaceMap::kBlockSide);
  return {c.x >> kShift, c.y >> kShift, c.z >> kShift};
}

std::size_t VoxelOf(const CubeIndex& c, const CubeIndex& block) {
  constexpr int n = SurfaceMap::kBlockSide;
  return static_cast<std::size_t>(((c.z - block.z * n) * n + (c.y - block.y * n)) * n +
                                  (c.x - block.x * n));
}

/// Of the 2 x 2 x 2 voxels in a block that hold this corner: its bit.
int BitOf(const CubeIndex& c) {
  constexpr int kMask = SurfaceMap::kBlockSide - 1;
  return (c.z & kMask) / 2 * 16 + (c.y & kMask) / 2 * 4 + (c.x & kMask) / 2;
}

// A corner that moved across its face since the camera saw it.
bool IsSeenFromBehind(const ExpiredFace& face, const Vector3d& n_W) {
  return face.eye_W && face.eye_W->allFinite() && n_W.dot(*face.eye_W - face.p_W[0]) < 0;
}

// Whether distances fall from one voxel to the next where a face would let them rise: they are of a
// surface that looks the other way. Merged, the two sides of something thin would cancel.
bool RunsAgainst(const SurfaceMap::Voxel& a, const SurfaceMap::Voxel& b, float step) {
  constexpr float kClear = 0.25F;  // of a step; less is noise, or an edge
  return (static_cast<int>(a.weight > 0) & static_cast<int>(b.weight > 0) &
          static_cast<int>((b.distance - a.distance) * step < -kClear * step * step)) != 0;
}

// What one face says about one voxel.
struct Sample {
  float distance, weight, intensity;
  int plane_id;
};

// There are no branches, because the processor could not predict what a voxel already holds.
void MergeInto(const Sample& sample, bool is_back, SurfaceMap::Voxel& voxel) {
  const float weight = is_back ? 0.0F : sample.weight;
  const float total = voxel.weight + weight, share = weight / total;
  voxel.distance += (sample.distance - voxel.distance) * share;
  voxel.intensity += (sample.intensity - voxel.intensity) * share;
  voxel.weight = std::min(total, kMaxWeight);
  voxel.plane_id = is_back || sample.plane_id < 0 ? voxel.plane_id : sample.plane_id;
}

// A surface that is looked through loses weight, so that those which are wrong go and those which
// were seen often stay.
void Weaken(float weight, SurfaceMap::Voxel& voxel) {
  voxel.weight -= weight;
  if (voxel.weight <= 0) voxel = SurfaceMap::Voxel();
}

void Prefetch(const void* address) {
#ifdef __GNUC__
  __builtin_prefetch(address, 1);
#endif
}

}  // namespace

const SurfaceMap::Voxel* SurfaceMap::Find(const CubeIndex& corner) const {
  const CubeIndex index = BlockOf(corner);
  const int block = index_.Find(index);
  if (block == CubeMap::kNone) return nullptr;
  const Voxel& voxel = blocks_[block].voxels[VoxelOf(corner, index)];
  return voxel.weight > 0 ? &voxel : nullptr;
}

const SurfaceMap::Block* SurfaceMap::FindBlock(const CubeIndex& index) const {
  const int block = index_.Find(index);
  return block == CubeMap::kNone ? nullptr : &blocks_[block];
}

std::vector<SurfaceMap::Block> SurfaceMap::TakeChanged(std::size_t max_blocks) {
  std::vector<Block> changed;
  for (std::size_t i = 0; i < blocks_.size() && changed.size() < max_blocks; ++i) {
    if (has_changed_[i] == 0) continue;
    changed.push_back(blocks_[i]);
    has_changed_[i] = 0;
  }
  return changed;
}

void SurfaceMap::SetBlock(const Block& block) {
  const int number = BlockAt(block.index);
  if (number == CubeMap::kNone) return;
  blocks_[number] = block;
  touched_[number] = ~std::uint64_t{0};
  has_changed_[number] = 1;
}

int SurfaceMap::AddBlock(const CubeIndex& index) {
  if (MegabytesOf(blocks_.size() + 1) > options_.max_memory_mb) {
    is_full_ = true;
    return CubeMap::kNone;
  }
  const int block = static_cast<int>(blocks_.size());
  index_.Add(index, block);
  blocks_.emplace_back();
  blocks_.back().index = index;
  touched_.push_back(0);
  has_changed_.push_back(0);
  return block;
}

SurfaceMap::KnownBlock& SurfaceMap::Know(const CubeIndex& index) {
  constexpr int kMask = kKnownSide - 1;
  const int place =
      ((index.z & kMask) * kKnownSide + (index.y & kMask)) * kKnownSide + (index.x & kMask);
  KnownBlock& known = known_[static_cast<std::size_t>(place)];
  if (known.index != index) known = {index, index_.Find(index)};
  return known;
}

int SurfaceMap::BlockAt(const CubeIndex& index) {
  KnownBlock& known = Know(index);
  if (known.block == CubeMap::kNone) known.block = AddBlock(index);
  return known.block;
}

void SurfaceMap::Touch(int block, const CubeIndex& first, int axis, int count) {
  // The four cubes along an axis from the block's lowest, and the way from one to the next.
  constexpr std::array<std::uint64_t, 3> kRow = {0xF, 0x1111, 0x0001000100010001};
  constexpr std::array<int, 3> kStride = {1, 4, 16};
  const int begin = std::array{first.x, first.y, first.z}[axis] & (kBlockSide - 1);
  const int missing = 3 - ((begin + count - 1) / 2 - begin / 2);
  touched_[block] |= kRow[axis] >> (missing * kStride[axis]) << BitOf(first);
}

// One look for the block serves all corners of the column inside it.
void SurfaceMap::SplitColumn(const Columns& all, const Column& column) {
  std::array<std::int32_t, 3> c = column.first;
  std::int32_t& at = c[all.axis];
  float distance = column.distance;
  while (at < column.end) {
    const CubeIndex corner{c[0], c[1], c[2]};
    const CubeIndex index = BlockOf(corner);
    const int block = BlockAt(index);
    const int count = std::min(kBlockSide - (at & (kBlockSide - 1)), column.end - at);
    at += count;
    if (block != CubeMap::kNone) {
      Touch(block, corner, all.axis, count);
      has_changed_[block] = 1;
      Voxel* const first = &blocks_[block].voxels[VoxelOf(corner, index)];
      for (int k = 0; k < count; ++k)
        Prefetch(first + k * all.stride);
      runs_.push_back({first, count, distance, column.weight, column.intensity});
    }
    distance += static_cast<float>(count) * all.step;
  }
}

void SurfaceMap::Merge(const Columns& all, const Run& run) {
  const auto voxel = [&](int k) -> Voxel& { return run.first[k * all.stride]; };
  // Before each voxel and behind the last one.
  std::array<bool, kBlockSide + 1> is_against{};
  for (int k = 1; k < run.count; ++k)
    is_against[k] = RunsAgainst(voxel(k - 1), voxel(k), all.step);
  float distance = run.distance;
  for (int k = 0; k < run.count; ++k) {
    MergeInto({distance, run.weight, run.intensity, all.plane_id},
              is_against[k] || is_against[k + 1],
              voxel(k));
    distance += all.step;
  }
}

// From the first place, where a face was seen, to the camera: the line was free.
void SurfaceMap::FollowSight(const Vector3d& from_W, const Vector3d& to_W, double begin_m) {
  const double length_m = (to_W - from_W).norm();
  const double way_m = std::min(length_m, kMaxSight_m) - kMinSight_m - begin_m;
  if (!(way_m > 0) || !std::isfinite(length_m)) return;
  const auto num_steps = static_cast<int>(std::ceil(way_m / options_.voxel_m / kSightStepVoxels));
  const Vector3d direction = (to_W - from_W) / length_m;
  // The corner of the grid that is nearest to a place is the floor of half a voxel more.
  const Vector3d begin = (from_W + begin_m * direction) / options_.voxel_m;
  GridLine<kBlockSide> line(begin + Vector3d::Constant(0.5), kSightStepVoxels * direction);
  CubeIndex index;
  int block = CubeMap::kNone;
  for (bool is_first = true; line.count() < num_steps; is_first = false) {
    const CubeIndex corner = line.Corner();
    if (is_first || BlockOf(corner) != index) {
      index = BlockOf(corner);
      block = Know(index).block;
    }
    if (block == CubeMap::kNone) {
      line.LeaveBlock(index);
      continue;
    }
    line.Advance();
    if ((touched_[block] >> BitOf(corner) & 1) == 0) continue;
    Voxel* const voxel = &blocks_[block].voxels[VoxelOf(corner, index)];
    Prefetch(voxel);
    has_changed_[block] = 1;
    seen_through_.push_back(voxel);
  }
}

// A face that is too small for a sight line shares one with others, and no face is looked through
// more often than its size asks for.
int SurfaceMap::RowsOfSights(double area_m2) {
  const double lines = area_m2 / (kSightArea * options_.voxel_m * options_.voxel_m);
  if (lines >= 1) {
    const double rows = std::sqrt(2 * lines + 0.25) - 0.5;  // with one, two, ... lines
    return static_cast<int>(std::min<double>(rows + 0.5, kMaxSightRows));
  }
  shared_sight_ += lines;
  if (!(shared_sight_ >= 1)) return 0;
  shared_sight_ -= 1;
  return 1;
}

// The face's own surface, up to where it is certain to end, is left alone.
void SurfaceMap::FollowSights(const Vector3d& eye_W,
                              const std::array<Vector3d, 3>& p_W,
                              const Vector3d& n_W) {
  const Vector3d &a = p_W[0], u = p_W[1] - a, v = p_W[2] - a;
  const int count = RowsOfSights(0.5 * u.cross(v).norm());
  const double reach_m = (kTruncationVoxels + 1) * options_.voxel_m;
  for (int i = 0; i < count; ++i) {
    for (int j = 0; i + j < count; ++j) {
      const Vector3d place = a + (i + 1.0 / 3) / count * u + (j + 1.0 / 3) / count * v;
      const Vector3d sight = eye_W - place;
      const double slope = std::abs(n_W.dot(sight)) / sight.norm();
      FollowSight(place, eye_W, reach_m / std::max(slope, 1e-3));
    }
  }
}

// Columns that meet the face, and what lies within the truncation along each.
void SurfaceMap::FollowColumns(const ExpiredFace& face,
                               const std::array<Vector3d, 3>& p,
                               const FlatFace& flat,
                               const Columns& all) {
  const double sigma = std::max(face.sigma_depth_m, 1e-3);
  const auto weight = static_cast<float>(
      std::clamp(std::pow(kUnitSigma_m / sigma, 2), kMinFaceWeight, kMaxFaceWeight));
  const float boundary_weight = weight * static_cast<float>(options_.boundary_weight);
  const double boundary = boundary_weight > 0 ? options_.boundary_m / options_.voxel_m : 0;
  const Footprint footprint(flat, p, face.is_boundary, boundary);
  const auto [darkest, brightest] =
      std::minmax_element(face.intensity.begin(), face.intensity.end());
  const ColumnFunction intensity = flat.Interpolate(face.intensity);
  const auto [u, v, w] = std::array{flat.u, flat.v, flat.w};
  const double reach = kTruncationVoxels / std::abs(flat.n[w]);
  const double step = flat.n[w] * options_.voxel_m;
  Column column;
  for (int y = footprint.rows().first; y <= footprint.rows().last; ++y) {
    const WholeNumbers columns = footprint.Columns(y), own = footprint.Own(y, columns);
    for (int x = columns.first; x <= columns.last; ++x) {
      const double centre = flat.plane(x, y);
      column.first[u] = x;
      column.first[v] = y;
      column.first[w] = FloorOf(centre - reach) + 1;
      column.end = FloorOf(centre + reach) + 1;
      column.distance = static_cast<float>(step * (column.first[w] - centre));
      column.weight = own.first <= x && x <= own.last ? weight : boundary_weight;
      column.intensity =
          static_cast<float>(std::clamp<double>(intensity(x, y), *darkest, *brightest));
      SplitColumn(all, column);
    }
  }
}

// Which voxels are meant is found out first: meanwhile the processor fetches them, which takes
// longer than all that is done with them.
void SurfaceMap::Add(const ExpiredFace& face) {
  std::array<Vector3d, 3> p = face.p_W;
  for (Vector3d& corner : p)
    corner /= options_.voxel_m;
  const FlatFace flat(p);
  if (!flat.is_valid || IsSeenFromBehind(face, flat.n)) return;
  if (options_.carving_weight > 0 && face.eye_W && face.eye_W->allFinite())
    FollowSights(*face.eye_W, face.p_W, flat.n);
  constexpr std::array<int, 3> kStride = {1, kBlockSide, kBlockSide * kBlockSide};
  const auto step_m = static_cast<float>(flat.n[flat.w] * options_.voxel_m);
  const Columns all = {flat.w, kStride[flat.w], step_m, face.plane_id};
  FollowColumns(face, p, flat, all);
  const auto carving_weight = static_cast<float>(options_.carving_weight);
  for (Voxel* voxel : seen_through_)
    Weaken(carving_weight, *voxel);
  for (const Run& run : runs_)
    Merge(all, run);
  seen_through_.clear();
  runs_.clear();
}

SurfaceMap WithHorizon(SurfaceMap map, HorizonMesh horizon) {
  horizon.Clear();
  for (const ExpiredFace& face : horizon.expired())
    map.Add(face);
  return map;
}

}  // namespace facet
