// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/surface_map.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr float kMaxWeight = 50;
// The weight of a face is 1 where the depth is this uncertain [m].
constexpr double kUnitSigma_m = 0.02;
constexpr double kMinFaceWeight = 1e-3, kMaxFaceWeight = 4;
// Faces reach this many voxels beyond their border: neighbours must meet.
constexpr double kBorderVoxels = 0.75;
constexpr double kMaxCoordinate_m = 1e5;

// Between the sight lines to one face, and between the places that are looked at along them.
constexpr double kSightDistanceVoxels = 6, kSightStepVoxels = 2;
// Sight lines to a face along its longest side, and the part of them that is followed.
constexpr int kMaxSightsPerSide = 30;
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

/// How far it is from p, in the block, to where the line leaves the block; all in voxels.
/// `inverse`: of the direction, by coordinate; 0 where that is 0.
double WayThroughBlock(const Vector3d& p, const Vector3d& inverse, const CubeIndex& block) {
  constexpr int n = SurfaceMap::kBlockSide;
  const Vector3d low = n * Vector3d(block.x, block.y, block.z);
  double way = 2 * n;
  for (int axis = 0; axis < 3; ++axis) {
    const double border = inverse[axis] > 0 ? low[axis] + n : low[axis];
    if (inverse[axis] != 0) way = std::min(way, (border - p[axis]) * inverse[axis]);
  }
  return way;
}

/// Of the 2 x 2 x 2 voxels in a block that hold this corner: its bit.
int BitOf(const CubeIndex& c) {
  constexpr int kMask = SurfaceMap::kBlockSide - 1;
  return (c.z & kMask) / 2 * 16 + (c.y & kMask) / 2 * 4 + (c.x & kMask) / 2;
}

/// A face as a plane with a border, seen along the axis of the grid that its normal is nearest to.
struct FlatFace {
  explicit FlatFace(const std::array<Vector3d, 3>& p) : a(p[0]) {
    const Vector3d twice_area = (p[1] - p[0]).cross(p[2] - p[0]);
    for (const Vector3d& corner : p)
      is_valid = is_valid && corner.cwiseAbs().maxCoeff() < kMaxCoordinate_m;
    is_valid = is_valid && twice_area.norm() > 1e-9;
    if (!is_valid) return;
    n = twice_area.normalized();
    n.cwiseAbs().maxCoeff(&w);
    u = (w + 1) % 3;
    v = (w + 2) % 3;
    const double side = n[w] > 0 ? 1 : -1;  // corners are counter-clockwise seen against n
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d& from = p[(i + 1) % 3];
      const Vector3d along = p[(i + 2) % 3] - from;
      inward[i] = side * Vector2d(-along[v], along[u]).normalized();
      offset[i] = inward[i].dot(Vector2d(from[u], from[v]));
      height[i] = std::max(inward[i].dot(Vector2d(p[i][u], p[i][v])) - offset[i], 1e-9);
    }
  }

  /// Whether the column of the grid meets the face or passes at most `border` beside it; its
  /// barycentric coordinates then, clamped to the face.
  bool Contains(const Vector2d& column, double border, std::array<double, 3>& share) const {
    for (std::size_t s = 0; s < 3; ++s) {
      share[s] = inward[s].dot(column) - offset[s];
      if (share[s] < -border) return false;
    }
    for (std::size_t s = 0; s < 3; ++s)
      share[s] = std::clamp(share[s] / height[s], 0.0, 1.0);
    return true;
  }

  Vector3d a, n = Vector3d::Zero();
  int u = 0, v = 1, w = 2;         // axes across the columns, and along them
  std::array<Vector2d, 3> inward;  // of the side opposite to corner i, across the columns
  std::array<double, 3> offset{}, height{};
  bool is_valid = true;
};

}  // namespace

const SurfaceMap::Voxel* SurfaceMap::Find(const CubeIndex& corner) const {
  const CubeIndex index = BlockOf(corner);
  const int block = index_.Find(index);
  if (block == CubeMap::kNone) return nullptr;
  const Voxel& voxel = blocks_[block].voxels[VoxelOf(corner, index)];
  return voxel.weight > 0 ? &voxel : nullptr;
}

// Null where a new block would be more than the map may have.
SurfaceMap::Block* SurfaceMap::BlockAt(const CubeIndex& index) {
  const int place = (index.x & 1) | (index.y & 1) << 1 | (index.z & 1) << 2;
  KnownBlock& known = cache_[static_cast<std::size_t>(place)];
  if (known.block != CubeMap::kNone && index == known.index) return &blocks_[known.block];
  int block = index_.Find(index);
  if (block == CubeMap::kNone) {
    if (MegabytesOf(blocks_.size() + 1) > options_.max_memory_mb) {
      is_full_ = true;
      return nullptr;
    }
    block = static_cast<int>(blocks_.size());
    index_.Add(index, block);
    blocks_.emplace_back();
    blocks_.back().index = index;
    touched_.push_back(0);
  }
  known = {index, block};
  return &blocks_[block];
}

void SurfaceMap::Merge(const Sample& sample, Voxel& voxel) {
  const float total = voxel.weight + sample.weight, share = sample.weight / total;
  voxel.distance += (sample.distance - voxel.distance) * share;
  voxel.intensity += (sample.intensity - voxel.intensity) * share;
  voxel.weight = std::min(total, kMaxWeight);
  if (sample.plane_id >= 0) voxel.plane_id = sample.plane_id;
}

void SurfaceMap::Touch(const Block& block, const CubeIndex& first, int axis, int count) {
  std::uint64_t& touched = touched_[static_cast<std::size_t>(&block - blocks_.data())];
  std::array<std::int32_t, 3> c = {first.x, first.y, first.z};
  for (int k = 0; k < count; ++k, ++c[axis])
    touched |= std::uint64_t{1} << BitOf({c[0], c[1], c[2]});
}

// One look for the block serves all corners of the column inside it.
void SurfaceMap::MergeColumn(const Column& column, Sample sample) {
  constexpr std::array<std::ptrdiff_t, 3> kStride = {1, kBlockSide, kBlockSide * kBlockSide};
  std::array<std::int32_t, 3> c = column.first;
  std::int32_t& at = c[column.axis];
  sample.distance = column.distance;
  while (at < column.end) {
    const CubeIndex corner{c[0], c[1], c[2]};
    const CubeIndex index = BlockOf(corner);
    Block* block = BlockAt(index);
    const std::int32_t left = kBlockSide - (at & (kBlockSide - 1));
    const std::int32_t count = std::min(left, column.end - at);
    Voxel* voxel = block == nullptr ? nullptr : &block->voxels[VoxelOf(corner, index)];
    if (voxel != nullptr) Touch(*block, corner, column.axis, count);
    for (std::int32_t k = 0; voxel != nullptr && k < count; ++k, voxel += kStride[column.axis]) {
      Merge(sample, *voxel);
      sample.distance += column.step;
    }
    if (block == nullptr) sample.distance += static_cast<float>(count) * column.step;
    at += count;
  }
}

// From the first place, where a face was seen, to the camera: the line was free. The surfaces that
// it meets lose weight, so that those which are wrong go and those which were seen often stay.
void SurfaceMap::CarveSight(const Vector3d& from_W, const Vector3d& to_W, double begin_m) {
  const double length_m = (to_W - from_W).norm();
  const double end = (std::min(length_m, kMaxSight_m) - kMinSight_m) / options_.voxel_m;
  // In voxels; the corner of the grid that is nearest to a place is the floor of p.
  const Vector3d from = from_W / options_.voxel_m + Vector3d::Constant(0.5);
  const Vector3d direction = (to_W - from_W) / length_m;
  const auto invert = [](double x) { return x == 0 ? 0 : 1 / x; };
  const Vector3d inverse = direction.unaryExpr(invert);
  CubeIndex index;
  int block = CubeMap::kNone;
  for (double t = begin_m / options_.voxel_m; t < end; t += kSightStepVoxels) {
    const Vector3d p = from + t * direction;
    const CubeIndex corner{FloorOf(p.x()), FloorOf(p.y()), FloorOf(p.z())};
    if (block == CubeMap::kNone || BlockOf(corner) != index) {
      index = BlockOf(corner);
      block = index_.Find(index);
    }
    if (block == CubeMap::kNone) {
      t += std::max(0.0, WayThroughBlock(p, inverse, index) - kSightStepVoxels);
      continue;
    }
    if ((touched_[block] >> BitOf(corner) & 1) == 0) continue;
    Voxel& voxel = blocks_[block].voxels[VoxelOf(corner, index)];
    voxel.weight -= static_cast<float>(options_.carving_weight);
    if (voxel.weight <= 0) voxel = Voxel();
  }
}

// The face's own surface, up to where it is certain to end, is left alone.
void SurfaceMap::CarveTowards(const Vector3d& eye_W,
                              const std::array<Vector3d, 3>& p_W,
                              const Vector3d& n_W) {
  const Vector3d &a = p_W[0], u = p_W[1] - a, v = p_W[2] - a;
  const double longest =
      std::sqrt(std::max({u.squaredNorm(), v.squaredNorm(), (u - v).squaredNorm()}));
  const double step_m = kSightDistanceVoxels * options_.voxel_m;
  const int parts = 1 + static_cast<int>(std::min<double>(longest / step_m, kMaxSightsPerSide - 1));
  for (int i = 0; i < parts; ++i) {
    for (int j = 0; i + j < parts; ++j) {
      const Vector3d place = a + (i + 1.0 / 3) / parts * u + (j + 1.0 / 3) / parts * v;
      const Vector3d sight = eye_W - place;
      const double slope = std::abs(n_W.dot(sight)) / sight.norm();
      CarveSight(place, eye_W, (options_.truncation_m + options_.voxel_m) / std::max(slope, 1e-3));
    }
  }
}

void SurfaceMap::Add(const LostFace& face) {
  const FlatFace flat(face.p_W);
  if (!flat.is_valid) return;
  if (options_.carving_weight > 0 && face.eye_W && face.eye_W->allFinite())
    CarveTowards(*face.eye_W, face.p_W, flat.n);
  const double voxel = options_.voxel_m, border = kBorderVoxels * voxel;
  const double sigma = std::max(face.sigma_depth_m, 1e-3);
  Sample sample;
  sample.weight = static_cast<float>(
      std::clamp(std::pow(kUnitSigma_m / sigma, 2), kMinFaceWeight, kMaxFaceWeight));
  sample.plane_id = face.plane_id;
  const Vector3d low = face.p_W[0].cwiseMin(face.p_W[1]).cwiseMin(face.p_W[2]);
  const Vector3d high = face.p_W[0].cwiseMax(face.p_W[1]).cwiseMax(face.p_W[2]);
  const auto [u, v, w] = std::array{flat.u, flat.v, flat.w};
  const auto floor_index = [voxel](double x) { return FloorOf(x / voxel); };
  const double half = options_.truncation_m / std::abs(flat.n[w]);
  Column column;
  column.axis = w;
  column.step = static_cast<float>(flat.n[w] * voxel);
  std::array<std::int32_t, 3> c{};
  std::array<double, 3> share{};
  const int u_end = floor_index(high[u] + border) + 1, v_end = floor_index(high[v] + border) + 1;
  const int v_begin = floor_index(low[v] - border) + 1;
  for (c[u] = floor_index(low[u] - border) + 1; c[u] < u_end; ++c[u]) {
    for (c[v] = v_begin; c[v] < v_end; ++c[v]) {
      const Vector2d place(c[u] * voxel, c[v] * voxel);
      if (!flat.Contains(place, border, share)) continue;
      sample.intensity =
          static_cast<float>((share[0] * face.intensity[0] + share[1] * face.intensity[1] +
                              share[2] * face.intensity[2]) /
                             std::max(share[0] + share[1] + share[2], 1e-6));
      // Where the column meets the plane; the part of it within the truncation is merged.
      const double centre =
          flat.a[w] -
          (flat.n[u] * (place.x() - flat.a[u]) + flat.n[v] * (place.y() - flat.a[v])) / flat.n[w];
      c[w] = floor_index(centre - half) + 1;
      column.first = c;
      column.end = floor_index(centre + half) + 1;
      column.distance = static_cast<float>(flat.n[w] * (c[w] * voxel - centre));
      MergeColumn(column, sample);
    }
  }
}

SurfaceMap WithHorizon(SurfaceMap map, HorizonMesh horizon) {
  horizon.Clear();
  for (const LostFace& face : horizon.lost())
    map.Add(face);
  return map;
}

}  // namespace facet
