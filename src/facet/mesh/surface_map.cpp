// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/surface_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "facet/mesh/triangle_rows.h"

namespace facet {
namespace {

constexpr float kMaxWeight = 50;
// The weight of a face is 1 where the depth is this uncertain [m].
constexpr double kUnitSigma_m = 0.02;
constexpr double kMinFaceWeight = 1e-3, kMaxFaceWeight = 4;
// Faces reach this many voxels beyond their border: neighbours must meet.
constexpr double kBorderVoxels = 0.3;
constexpr double kMaxCoordinate = 1e7, kMinTwiceArea = 1e-7;  // voxels
constexpr WholeNumbers kAnywhere = {std::numeric_limits<int>::min(),
                                    std::numeric_limits<int>::max()};

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

/// A line through the grid in equal steps, in whole numbers: 2^-32 of a voxel, whose upper halves
/// are the voxels that it passes.
class GridLine {
 public:
  GridLine(const Vector3d& begin, const Vector3d& step)
      : begin_(begin), step_(step), at_(Fixed(begin)), per_step_(Fixed(step)) {
    for (int axis = 0; axis < 3; ++axis)
      inverse_[axis] = step[axis] == 0 ? 0 : 1 / step[axis];
  }

  CubeIndex Corner() const { return {Whole(at_[0]), Whole(at_[1]), Whole(at_[2])}; }

  void Advance() {
    for (int axis = 0; axis < 3; ++axis)
      at_[axis] += per_step_[axis];
    ++count_;
  }

  /// To the first place behind the block that holds the present one.
  void LeaveBlock(const CubeIndex& block) {
    constexpr int n = SurfaceMap::kBlockSide;
    const Vector3d low = n * Vector3d(block.x, block.y, block.z);
    double last = count_ + 2 * n;
    for (int axis = 0; axis < 3; ++axis) {
      const double border = step_[axis] > 0 ? low[axis] + n : low[axis];
      if (step_[axis] != 0) last = std::min(last, (border - begin_[axis]) * inverse_[axis]);
    }
    count_ = std::max(count_ + 1, static_cast<int>(last) + 1);
    at_ = Fixed(begin_ + count_ * step_);
  }

  int count() const { return count_; }  ///< steps so far

 private:
  using FixedPoint = std::array<std::int64_t, 3>;
  static std::int32_t Whole(std::int64_t x) { return static_cast<std::int32_t>(x >> 32); }
  static FixedPoint Fixed(const Vector3d& v) {
    constexpr double kUnit = 4294967296.0;
    return {static_cast<std::int64_t>(kUnit * v.x()),
            static_cast<std::int64_t>(kUnit * v.y()),
            static_cast<std::int64_t>(kUnit * v.z())};
  }

  Vector3d begin_, step_, inverse_;
  FixedPoint at_, per_step_;
  int count_ = 0;
};

/// Of the 2 x 2 x 2 voxels in a block that hold this corner: its bit.
int BitOf(const CubeIndex& c) {
  constexpr int kMask = SurfaceMap::kBlockSide - 1;
  return (c.z & kMask) / 2 * 16 + (c.y & kMask) / 2 * 4 + (c.x & kMask) / 2;
}

/// A linear function of a place across the columns of the grid.
struct Linear {
  Vector2d slope = Vector2d::Zero();
  double at_origin = 0;
  double operator()(double x, double y) const { return at_origin + slope.x() * x + slope.y() * y; }
};

/// A face as a plane with a border, seen along the axis of the grid that its normal is nearest to.
/// In voxels.
struct FlatFace {
  explicit FlatFace(const std::array<Vector3d, 3>& p) {
    const Vector3d twice_area = (p[1] - p[0]).cross(p[2] - p[0]);
    for (const Vector3d& corner : p)
      is_valid = is_valid && corner.cwiseAbs().maxCoeff() < kMaxCoordinate;
    is_valid = is_valid && twice_area.norm() > kMinTwiceArea;
    if (!is_valid) return;
    n = twice_area.normalized();
    n.cwiseAbs().maxCoeff(&w);
    u = (w + 1) % 3;
    v = (w + 2) % 3;
    plane.slope = -Vector2d(n[u], n[v]) / n[w];
    plane.at_origin = p[0][w] - plane.slope.dot(Vector2d(p[0][u], p[0][v]));
    const double side = n[w] > 0 ? 1 : -1;  // corners are counter-clockwise seen against n
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d& from = p[(i + 1) % 3];
      const Vector3d along = p[(i + 2) % 3] - from;
      inward[i] = side * Vector2d(-along[v], along[u]).normalized();
      offset[i] = inward[i].dot(Vector2d(from[u], from[v]));
      const double height = inward[i].dot(Vector2d(p[i][u], p[i][v])) - offset[i];
      share[i].slope = inward[i] / std::max(height, 1e-9);
      share[i].at_origin = -offset[i] / std::max(height, 1e-9);
    }
  }

  /// Continued beyond the border.
  Linear Interpolate(const std::array<std::uint8_t, 3>& values) const {
    Linear sum;
    for (std::size_t i = 0; i < 3; ++i) {
      sum.slope += values[i] * share[i].slope;
      sum.at_origin += values[i] * share[i].at_origin;
    }
    return sum;
  }

  /// The columns of the grid that meet the face or pass at most `border` beside each side.
  TriangleRows Inside(const std::array<double, 3>& border) const {
    return {inward, {offset[0] - border[0], offset[1] - border[1], offset[2] - border[2]}};
  }

  Vector3d n = Vector3d::Zero();
  int u = 0, v = 1, w = 2;         // axes across the columns, and along them
  Linear plane;                    // where the columns meet it
  std::array<Vector2d, 3> inward;  // of the side opposite to corner i, across the columns
  std::array<double, 3> offset{};
  std::array<Linear, 3> share;  // barycentric coordinates
  bool is_valid = true;
};

/// The columns of the grid along which a face is merged: its own, and what is expected beyond its
/// rim.
class Footprint {
 public:
  Footprint(const FlatFace& flat,
            const std::array<Vector3d, 3>& p,
            const std::array<bool, 3>& is_rim,
            double rim)
      : own_(flat.Inside({kBorderVoxels, kBorderVoxels, kBorderVoxels})), all_(own_) {
    double widest = kBorderVoxels;
    if (is_rim[0] || is_rim[1] || is_rim[2]) {
      widest = std::max(kBorderVoxels, rim);
      const auto border = [&](std::size_t i) { return is_rim[i] ? widest : kBorderVoxels; };
      all_ = flat.Inside({border(0), border(1), border(2)});
      has_rim_ = true;
    }
    const Vector3d low = p[0].cwiseMin(p[1]).cwiseMin(p[2]) - Vector3d::Constant(widest);
    const Vector3d high = p[0].cwiseMax(p[1]).cwiseMax(p[2]) + Vector3d::Constant(widest);
    columns_ = WholeNumbersBetween(low[flat.u], high[flat.u], kAnywhere);
    rows_ = WholeNumbersBetween(low[flat.v], high[flat.v], kAnywhere);
  }

  const WholeNumbers& rows() const { return rows_; }
  WholeNumbers Columns(int row) const { return all_.Columns(row, columns_); }
  /// Those of them that are the face's own.
  WholeNumbers Own(int row, const WholeNumbers& columns) const {
    return has_rim_ ? own_.Columns(row, columns) : columns;
  }

 private:
  TriangleRows own_, all_;
  WholeNumbers columns_, rows_;
  bool has_rim_ = false;
};

// A corner that moved across its face since the camera saw it.
bool IsSeenFromBehind(const LostFace& face, const Vector3d& n_W) {
  return face.eye_W && face.eye_W->allFinite() && n_W.dot(*face.eye_W - face.p_W[0]) < 0;
}

// Whether distances fall from one voxel to the next where a face would let them rise: they are of a
// surface that looks the other way. Merged, the two sides of something thin would cancel.
bool RunsAgainst(const SurfaceMap::Voxel& a, const SurfaceMap::Voxel& b, float step) {
  constexpr float kClear = 0.25F;  // of a step; less is noise, or an edge
  return a.weight > 0 && b.weight > 0 && (b.distance - a.distance) * step < -kClear * step * step;
}

}  // namespace

const SurfaceMap::Voxel* SurfaceMap::Find(const CubeIndex& corner) const {
  const CubeIndex index = BlockOf(corner);
  const int block = index_.Find(index);
  if (block == CubeMap::kNone) return nullptr;
  const Voxel& voxel = blocks_[block].voxels[VoxelOf(corner, index)];
  return voxel.weight > 0 ? &voxel : nullptr;
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
  return block;
}

int SurfaceMap::BlockAt(const CubeIndex& index) {
  const int place = (index.x & 1) | (index.y & 1) << 1 | (index.z & 1) << 2;
  KnownBlock& known = cache_[static_cast<std::size_t>(place)];
  if (known.block != CubeMap::kNone && index == known.index) return known.block;
  int block = index_.Find(index);
  if (block == CubeMap::kNone) block = AddBlock(index);
  if (block != CubeMap::kNone) known = {index, block};
  return block;
}

void SurfaceMap::Merge(const Sample& sample, Voxel& voxel) {
  const float total = voxel.weight + sample.weight, share = sample.weight / total;
  voxel.distance += (sample.distance - voxel.distance) * share;
  voxel.intensity += (sample.intensity - voxel.intensity) * share;
  voxel.weight = std::min(total, kMaxWeight);
  if (sample.plane_id >= 0) voxel.plane_id = sample.plane_id;
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
void SurfaceMap::MergeColumn(const Column& column, Sample sample) {
  constexpr std::array<std::ptrdiff_t, 3> kStride = {1, kBlockSide, kBlockSide * kBlockSide};
  std::array<std::int32_t, 3> c = column.first;
  std::int32_t& at = c[column.axis];
  sample.distance = column.distance;
  while (at < column.end) {
    const CubeIndex corner{c[0], c[1], c[2]};
    const CubeIndex index = BlockOf(corner);
    const int block = BlockAt(index);
    const std::int32_t left = kBlockSide - (at & (kBlockSide - 1));
    const std::int32_t count = std::min(left, column.end - at);
    at += count;
    if (block == CubeMap::kNone) {
      sample.distance += static_cast<float>(count) * column.step;
      continue;
    }
    Touch(block, corner, column.axis, count);
    Voxel* voxel = &blocks_[block].voxels[VoxelOf(corner, index)];
    const std::ptrdiff_t stride = kStride[column.axis];
    Voxel before;
    for (std::int32_t k = 0; k < count; ++k, voxel += stride) {
      const bool is_back = RunsAgainst(before, *voxel, column.step) ||
                           (k + 1 < count && RunsAgainst(*voxel, voxel[stride], column.step));
      before = *voxel;
      if (!is_back) Merge(sample, *voxel);
      sample.distance += column.step;
    }
  }
}

// From the first place, where a face was seen, to the camera: the line was free. The surfaces that
// it meets lose weight, so that those which are wrong go and those which were seen often stay.
void SurfaceMap::CarveSight(const Vector3d& from_W, const Vector3d& to_W, double begin_m) {
  const double length_m = (to_W - from_W).norm();
  const double way_m = std::min(length_m, kMaxSight_m) - kMinSight_m - begin_m;
  if (!(way_m > 0) || !std::isfinite(length_m)) return;
  const auto num_steps = static_cast<int>(std::ceil(way_m / options_.voxel_m / kSightStepVoxels));
  const Vector3d direction = (to_W - from_W) / length_m;
  // The corner of the grid that is nearest to a place is the floor of half a voxel more.
  const Vector3d begin = (from_W + begin_m * direction) / options_.voxel_m;
  GridLine line(begin + Vector3d::Constant(0.5), kSightStepVoxels * direction);
  CubeIndex index;
  int block = CubeMap::kNone;
  for (bool is_first = true; line.count() < num_steps; is_first = false) {
    const CubeIndex corner = line.Corner();
    if (is_first || BlockOf(corner) != index) {
      index = BlockOf(corner);
      block = index_.Find(index);
    }
    if (block == CubeMap::kNone) {
      line.LeaveBlock(index);
      continue;
    }
    line.Advance();
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
  std::array<Vector3d, 3> p = face.p_W;
  for (Vector3d& corner : p)
    corner /= options_.voxel_m;
  const FlatFace flat(p);
  if (!flat.is_valid || IsSeenFromBehind(face, flat.n)) return;
  if (options_.carving_weight > 0 && face.eye_W && face.eye_W->allFinite())
    CarveTowards(*face.eye_W, face.p_W, flat.n);
  const double sigma = std::max(face.sigma_depth_m, 1e-3);
  const auto weight = static_cast<float>(
      std::clamp(std::pow(kUnitSigma_m / sigma, 2), kMinFaceWeight, kMaxFaceWeight));
  const float rim_weight = weight * static_cast<float>(options_.rim_weight);
  Sample sample;
  sample.plane_id = face.plane_id;
  const auto [darkest, brightest] =
      std::minmax_element(face.intensity.begin(), face.intensity.end());
  const Linear intensity = flat.Interpolate(face.intensity);
  const auto [u, v, w] = std::array{flat.u, flat.v, flat.w};
  const Footprint footprint(flat, p, face.is_rim, options_.rim_m / options_.voxel_m);
  // Along a column, what lies within the truncation is merged.
  const double reach = options_.truncation_m / options_.voxel_m / std::abs(flat.n[w]);
  const double step = flat.n[w] * options_.voxel_m;
  Column column;
  column.axis = w;
  column.step = static_cast<float>(step);
  for (int y = footprint.rows().first; y <= footprint.rows().last; ++y) {
    const WholeNumbers columns = footprint.Columns(y), own = footprint.Own(y, columns);
    for (int x = columns.first; x <= columns.last; ++x) {
      const double centre = flat.plane(x, y);
      column.first[u] = x;
      column.first[v] = y;
      column.first[w] = FloorOf(centre - reach) + 1;
      column.end = FloorOf(centre + reach) + 1;
      column.distance = static_cast<float>(step * (column.first[w] - centre));
      sample.weight = own.first <= x && x <= own.last ? weight : rim_weight;
      sample.intensity =
          static_cast<float>(std::clamp<double>(intensity(x, y), *darkest, *brightest));
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
