// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/surface_map.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr float kMaxWeight = 50;
// The weight of a face is 1 where the depth is this uncertain [m].
constexpr double kUnitSigma_m = 0.02;
constexpr double kMaxFaceWeight = 4;
// Faces reach this many voxels beyond their border: neighbours must meet.
constexpr double kBorderVoxels = 0.75;
constexpr double kMaxCoordinate_m = 1e5;

std::int32_t FloorDivide(std::int32_t a, std::int32_t b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

CubeIndex BlockOf(const CubeIndex& c) {
  constexpr int n = SurfaceMap::kBlockSide;
  return {FloorDivide(c.x, n), FloorDivide(c.y, n), FloorDivide(c.z, n)};
}

std::size_t VoxelOf(const CubeIndex& c, const CubeIndex& block) {
  constexpr int n = SurfaceMap::kBlockSide;
  return static_cast<std::size_t>(((c.z - block.z * n) * n + (c.y - block.y * n)) * n +
                                  (c.x - block.x * n));
}

/// A face as a plane with a border, to ask grid corners about.
struct FlatFace {
  explicit FlatFace(const std::array<Vector3d, 3>& p) : a(p[0]) {
    const Vector3d twice_area = (p[1] - p[0]).cross(p[2] - p[0]);
    is_valid = twice_area.norm() > 1e-9 && p[0].cwiseAbs().maxCoeff() < kMaxCoordinate_m &&
               p[1].cwiseAbs().maxCoeff() < kMaxCoordinate_m &&
               p[2].cwiseAbs().maxCoeff() < kMaxCoordinate_m;
    if (!is_valid) return;
    n = twice_area.normalized();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d& from = p[(i + 1) % 3];
      inward[i] = n.cross(p[(i + 2) % 3] - from).normalized();
      offset[i] = inward[i].dot(from);
      height[i] = inward[i].dot(p[i]) - offset[i];
    }
  }

  /// Whether the foot of p on the plane is inside or at most `border` outside; its barycentric
  /// coordinates then, clamped to the face.
  bool Contains(const Vector3d& p, double border, std::array<double, 3>& share) const {
    for (std::size_t s = 0; s < 3; ++s) {
      const double inside = inward[s].dot(p) - offset[s];
      if (inside < -border) return false;
      share[s] = std::clamp(inside / height[s], 0.0, 1.0);
    }
    return true;
  }

  Vector3d a, n;
  std::array<Vector3d, 3> inward;  // of the side opposite to corner i, in the face's plane
  std::array<double, 3> offset{}, height{};
  bool is_valid = false;
};

}  // namespace

const SurfaceMap::Voxel* SurfaceMap::Find(const CubeIndex& corner) const {
  const CubeIndex block = BlockOf(corner);
  const auto found = index_.find(block);
  if (found == index_.end()) return nullptr;
  const Voxel& voxel = blocks_[found->second].voxels[VoxelOf(corner, block)];
  return voxel.weight > 0 ? &voxel : nullptr;
}

SurfaceMap::Voxel& SurfaceMap::At(const CubeIndex& corner) {
  const CubeIndex block = BlockOf(corner);
  if (last_block_ < 0 || block != last_index_) {
    const auto [found, is_new] = index_.try_emplace(block, static_cast<int>(blocks_.size()));
    if (is_new) {
      blocks_.emplace_back();
      blocks_.back().index = block;
    }
    last_block_ = found->second;
    last_index_ = block;
  }
  return blocks_[last_block_].voxels[VoxelOf(corner, block)];
}

void SurfaceMap::Add(const LostFace& face) {
  const FlatFace flat(face.p_W);
  if (!flat.is_valid) return;
  const double voxel = options_.voxel_m, truncation = options_.truncation_m;
  const double border = kBorderVoxels * voxel;
  const double sigma = std::max(face.sigma_depth_m, 1e-3);
  const auto weight =
      static_cast<float>(std::clamp(std::pow(kUnitSigma_m / sigma, 2), 1e-3, kMaxFaceWeight));
  const Vector3d low = face.p_W[0].cwiseMin(face.p_W[1]).cwiseMin(face.p_W[2]);
  const Vector3d high = face.p_W[0].cwiseMax(face.p_W[1]).cwiseMax(face.p_W[2]);
  // Runs along the axis that the normal is nearest to: few corners are visited in vain.
  int w = 0;
  flat.n.cwiseAbs().maxCoeff(&w);
  const int u = (w + 1) % 3, v = (w + 2) % 3;
  const double reach = truncation * std::sqrt(1 - flat.n[w] * flat.n[w]) + border;
  const auto floor_index = [&](double x) { return static_cast<int>(std::floor(x / voxel)); };
  for (int i = floor_index(low[u] - reach) + 1; i <= floor_index(high[u] + reach); ++i) {
    for (int j = floor_index(low[v] - reach) + 1; j <= floor_index(high[v] + reach); ++j) {
      // Where the column meets the plane, and the part of it within the truncation.
      const double du = i * voxel - flat.a[u], dv = j * voxel - flat.a[v];
      const double centre = flat.a[w] - (flat.n[u] * du + flat.n[v] * dv) / flat.n[w];
      const double half = truncation / std::abs(flat.n[w]);
      for (int k = floor_index(centre - half) + 1; k <= floor_index(centre + half); ++k) {
        Vector3d p;
        p[u] = i * voxel;
        p[v] = j * voxel;
        p[w] = k * voxel;
        std::array<double, 3> share{};
        if (!flat.Contains(p, border, share)) continue;
        std::array<std::int32_t, 3> c{};
        c[u] = i;
        c[v] = j;
        c[w] = k;
        Voxel& cell = At({c[0], c[1], c[2]});
        const float total = cell.weight + weight;
        const auto distance = static_cast<float>(flat.n.dot(p - flat.a));
        const auto intensity =
            static_cast<float>((share[0] * face.intensity[0] + share[1] * face.intensity[1] +
                                share[2] * face.intensity[2]) /
                               std::max(share[0] + share[1] + share[2], 1e-6));
        cell.distance += (distance - cell.distance) * weight / total;
        cell.intensity += (intensity - cell.intensity) * weight / total;
        cell.weight = std::min(total, kMaxWeight);
        if (face.plane_id >= 0) cell.plane_id = face.plane_id;
      }
    }
  }
}

}  // namespace facet
