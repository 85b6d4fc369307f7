// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/region_growing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace facet {

namespace {

const double kMinCosine = std::cos(15 * std::numbers::pi / 180);
constexpr double kMinGrowthBand_m = 0.02;
constexpr double kMaxBand_m = 0.08;

// For each face of the pool its neighbours in the pool, across its sides.
class Adjacency {
 public:
  Adjacency(const SurfaceFaces& faces, std::span<const int> pool) : first_(pool.size() + 1, 0) {
    const std::vector<Side> sides = SortedSides(faces, pool);
    std::vector<std::pair<int, int>> pairs;
    for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
      for (std::size_t j = i + 1; j < sides.size() && sides[j].HasEndsOf(sides[i]); ++j) {
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
    int low = 0, high = 0;  // both ends
    int place = 0;          // of the face in the pool
    bool HasEndsOf(const Side& other) const { return low == other.low && high == other.high; }
    bool operator<(const Side& other) const {
      return high != other.high ? high < other.high : place < other.place;
    }
  };

  // Sorts the sides by their lower end, with a counting sort; few sides share one, and these are
  // then sorted among themselves.
  static std::vector<Side> SortedSides(const SurfaceFaces& faces, std::span<const int> pool) {
    std::vector<int> next(faces.points.size() + 1, 0);
    const auto visit = [&](const auto& function) {
      for (std::size_t i = 0; i < pool.size(); ++i) {
        const auto& c = faces.faces[pool[i]].corners;
        for (int k = 0; k < 3; ++k) {
          const auto [low, high] = std::minmax(c[k], c[(k + 1) % 3]);
          function(Side{low, high, static_cast<int>(i)});
        }
      }
    };
    visit([&](const Side& side) { ++next[side.low + 1]; });
    std::partial_sum(next.begin(), next.end(), next.begin());
    std::vector<Side> sides(3 * pool.size());
    visit([&](const Side& side) { sides[next[side.low]++] = side; });
    int begin = 0;  // now `next` says where each end's sides end
    for (std::size_t low = 0; low < faces.points.size(); ++low) {
      std::sort(sides.begin() + begin, sides.begin() + next[low]);
      begin = next[low];
    }
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
    search_area_m2_ += face.search_area_m2;
  }

  bool Accepts(const SurfaceFaces& faces, const SurfaceFace& face) const {
    const Plane plane = ToPlane();
    if (std::abs(plane.n.dot(face.n_W)) < kMinCosine) return false;
    return std::all_of(face.corners.begin(), face.corners.end(), [&](int corner) {
      const FacePoint& point = faces.points[corner];
      const double distance = std::abs(plane.SignedDistance(point.p_W));
      if (distance <= point.length_scale * kMinGrowthBand_m) return true;
      return distance <= point.length_scale * kMaxBand_m &&
             distance <= 3 * point.SigmaAlong(plane.n);
    });
  }

  Plane ToPlane() const {
    const Vector3d n = normal_.normalized();
    return {n, n.dot(moment_) / area_m2_};
  }
  double search_area_m2() const { return search_area_m2_; }

 private:
  Vector3d normal_ = Vector3d::Zero(), moment_ = Vector3d::Zero();
  double area_m2_ = 0, search_area_m2_ = 0;
};

}  // namespace

std::vector<Plane> GrowRegions(const SurfaceFaces& faces,
                               std::span<const int> pool,
                               double min_area_m2) {
  std::vector<std::pair<double, int>> seeds;  // less area, place: the largest first
  seeds.reserve(pool.size());
  for (std::size_t i = 0; i < pool.size(); ++i)
    seeds.emplace_back(-faces.faces[pool[i]].area_m2, static_cast<int>(i));
  std::sort(seeds.begin(), seeds.end());
  const Adjacency adjacency(faces, pool);
  std::vector<char> used(pool.size(), 0);
  std::vector<std::pair<double, Plane>> regions;
  std::vector<int> open;
  for (const auto& [less_area, seed] : seeds) {
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
    if (plane.search_area_m2() >= min_area_m2)
      regions.emplace_back(plane.search_area_m2(), plane.ToPlane());
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
