// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/region_growing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

namespace facet {

namespace {

constexpr double kMaxAngle = 15 * std::numbers::pi / 180;
constexpr double kMinBand_m = 0.02;
constexpr double kMaxBand_m = 0.08;

// For each face of the pool its up to three neighbours in the pool, across its sides.
class Adjacency {
 public:
  Adjacency(const SurfaceFaces& faces, std::span<const int> pool) : neighbours_(pool.size()) {
    struct Side {
      int a, b, place;
      bool operator<(const Side& other) const {
        return std::tie(a, b, place) < std::tie(other.a, other.b, other.place);
      }
    };
    std::vector<Side> sides;
    sides.reserve(3 * pool.size());
    for (std::size_t i = 0; i < pool.size(); ++i) {
      const auto& c = faces.faces[pool[i]].corners;
      for (int k = 0; k < 3; ++k) {
        const auto [a, b] = std::minmax(c[k], c[(k + 1) % 3]);
        sides.push_back({a, b, static_cast<int>(i)});
      }
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
      for (std::size_t j = i + 1;
           j < sides.size() && sides[j].a == sides[i].a && sides[j].b == sides[i].b;
           ++j) {
        neighbours_[sides[i].place].push_back(sides[j].place);
        neighbours_[sides[j].place].push_back(sides[i].place);
      }
    }
  }

  const std::vector<int>& Of(int place) const { return neighbours_[place]; }

 private:
  std::vector<std::vector<int>> neighbours_;  // places in the pool
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
    if (std::abs(plane.n.dot(face.n_W)) < std::cos(kMaxAngle)) return false;
    return std::all_of(face.corners.begin(), face.corners.end(), [&](int corner) {
      const SurfacePoint& point = faces.points[corner];
      const double band = std::clamp(3 * point.SigmaAlong(plane.n), kMinBand_m, kMaxBand_m);
      return std::abs(plane.SignedDistance(point.p_W)) <= band;
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
