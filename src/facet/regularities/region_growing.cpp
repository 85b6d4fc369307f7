// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/region_growing.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <utility>

namespace facet {

namespace {

const double kMinCosine = std::cos(15 * std::numbers::pi / 180);
constexpr double kMinBand_m = 0.02;
constexpr double kMaxBand_m = 0.08;

// For each face of the pool its neighbours in the pool, across its sides.
class Adjacency {
 public:
  Adjacency(const SurfaceFaces& faces, std::span<const int> pool) : first_(pool.size() + 1, 0) {
    const std::vector<Side> sides = SortedSides(faces, pool);
    std::vector<std::pair<int, int>> pairs;
    for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
      for (std::size_t j = i + 1; j < sides.size() && sides[j].key == sides[i].key; ++j) {
        pairs.emplace_back(sides[i].place, sides[j].place);
        ++first_[static_cast<std::size_t>(sides[i].place) + 1];
        ++first_[static_cast<std::size_t>(sides[j].place) + 1];
      }
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    neighbours_.resize(2 * pairs.size());
    std::vector<int> next(first_.begin(), first_.end() - 1);
    for (const auto& [a, b] : pairs) {
      neighbours_[next[a]++] = b;
      neighbours_[next[b]++] = a;
    }
  }

  std::span<const int> Of(int place) const {
    return std::span(neighbours_).subspan(first_[place], first_[place + 1] - first_[place]);
  }

 private:
  struct Side {
    std::uint64_t key;  // both ends
    int place;          // of the face in the pool
    bool operator<(const Side& other) const {
      return key != other.key ? key < other.key : place < other.place;
    }
  };

  static std::vector<Side> SortedSides(const SurfaceFaces& faces, std::span<const int> pool) {
    std::vector<Side> sides;
    sides.reserve(3 * pool.size());
    for (std::size_t i = 0; i < pool.size(); ++i) {
      const auto& c = faces.faces[pool[i]].corners;
      for (int k = 0; k < 3; ++k) {
        const auto [a, b] = std::minmax(c[k], c[(k + 1) % 3]);
        sides.push_back({static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint64_t>(b),
                         static_cast<int>(i)});
      }
    }
    std::sort(sides.begin(), sides.end());
    return sides;
  }

  std::vector<int> first_;  // by place in the pool: where its neighbours begin
  std::vector<int> neighbours_;
};

// A plane that follows what was added to it, weighted by area.
class GrowingPlane {
 public:
  explicit GrowingPlane(const SurfaceFace& seed) { Add(seed); }

  void Add(const SurfaceFace& face) {
    const double sign = normal_.dot(face.n_W) < 0 ? -1 : 1;
    normal_ += sign * face.area_m2 * face.n_W;
    moment_ += face.area_m2 * face.centre_W;
    area_m2_ += face.area_m2;
  }

  bool Accepts(const SurfaceFaces& faces, const SurfaceFace& face) const {
    const Plane plane = ToPlane();
    if (std::abs(plane.n.dot(face.n_W)) < kMinCosine) return false;
    return std::all_of(face.corners.begin(), face.corners.end(), [&](int corner) {
      const FacePoint& point = faces.points[corner];
      const double distance = std::abs(plane.SignedDistance(point.p_W));
      if (distance <= kMinBand_m) return true;
      return distance <= kMaxBand_m && distance <= 3 * point.SigmaAlong(plane.n);
    });
  }

  Plane ToPlane() const {
    const Vector3d n = normal_.normalized();
    return {n, n.dot(moment_) / area_m2_};
  }
  double area_m2() const { return area_m2_; }

 private:
  Vector3d normal_ = Vector3d::Zero(), moment_ = Vector3d::Zero();
  double area_m2_ = 0;
};

}  // namespace

std::vector<Plane> GrowRegions(const SurfaceFaces& faces,
                               std::span<const int> pool,
                               double min_area_m2) {
  std::vector<int> seeds(pool.size());
  for (std::size_t i = 0; i < seeds.size(); ++i)
    seeds[i] = static_cast<int>(i);
  std::stable_sort(seeds.begin(), seeds.end(), [&](int i, int j) {
    return faces.faces[pool[i]].area_m2 > faces.faces[pool[j]].area_m2;
  });
  const Adjacency adjacency(faces, pool);
  std::vector<char> used(pool.size(), 0);
  std::vector<std::pair<double, Plane>> regions;
  std::vector<int> open;
  for (const int seed : seeds) {
    if (used[seed] != 0) continue;
    GrowingPlane plane(faces.faces[pool[seed]]);
    used[seed] = 1;
    open.assign(1, seed);
    for (std::size_t next = 0; next < open.size(); ++next) {
      for (const int neighbour : adjacency.Of(open[next])) {
        const SurfaceFace& face = faces.faces[pool[neighbour]];
        if (used[neighbour] != 0 || !plane.Accepts(faces, face)) continue;
        used[neighbour] = 1;
        plane.Add(face);
        open.push_back(neighbour);
      }
    }
    if (plane.area_m2() >= min_area_m2) regions.emplace_back(plane.area_m2(), plane.ToPlane());
  }
  std::stable_sort(regions.begin(), regions.end(), [](const auto& a, const auto& b) {
    return a.first > b.first;
  });
  std::vector<Plane> out;
  for (const auto& [area, plane] : regions)
    out.push_back(plane);
  return out;
}

}  // namespace facet
