// SPDX-License-Identifier: BSD-2-Clause
#include "plane_members.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace facet {

PlaneMembers::PlaneMembers(const std::filesystem::path& sequence)
    : planes_G_(ReadTruePlanes(sequence / "truth" / "planes.csv")) {}

void PlaneMembers::Add(const MapSnapshot& map) {
  for (const LandmarkEstimate& landmark : map.landmarks) {
    for (const PlaneId plane : landmark.planes) {
      if (plane.IsValid()) members_[plane].insert(landmark.id);
    }
  }
}

std::vector<std::pair<int, int>> PlaneMembers::TrueSurfacesOf(
    const std::vector<ScenePoint>& members) {
  std::map<int, int> votes;
  for (const ScenePoint& member : members)
    ++votes[member.plane];
  std::vector<std::pair<int, int>> sorted(votes.begin(), votes.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
    return a.second > b.second;
  });
  return sorted;
}

void PlaneMembers::PrintPlane(PlaneId id, const std::vector<std::pair<int, int>>& surfaces) const {
  constexpr std::size_t kShown = 6;
  std::printf("  plane %s:", std::to_string(id.value).c_str());
  for (std::size_t k = 0; k < std::min(kShown, surfaces.size()); ++k) {
    const auto [plane, count] = surfaces[k];
    if (plane < 0) {
      std::printf("  %d curved", count);
      continue;
    }
    const TruePlane& p = planes_G_[static_cast<std::size_t>(plane)];
    std::printf("  %d %s %d", count, p.label.c_str(), plane);
  }
  std::printf("\n");
}

void PlaneMembers::Print(const PointOf& point_of) const {
  constexpr double kLimits_m[] = {0.003, 0.01, 0.02, 0.03};
  constexpr int kBins = 5;
  int counts[kBins] = {}, total = 0;
  if (!members_.empty()) std::printf("landmarks of each plane by the surface they truly are on\n");
  for (const auto& [id, landmarks] : members_) {
    std::vector<ScenePoint> members;
    for (const LandmarkId landmark : landmarks) {
      if (const ScenePoint* point = point_of(landmark)) members.push_back(*point);
    }
    const std::vector<std::pair<int, int>> surfaces = TrueSurfacesOf(members);
    PrintPlane(id, surfaces);
    const auto first =
        std::find_if(surfaces.begin(), surfaces.end(), [](const auto& s) { return s.first >= 0; });
    if (first == surfaces.end()) continue;
    const TruePlane& truth = planes_G_[static_cast<std::size_t>(first->first)];
    for (const ScenePoint& member : members) {
      const double distance_m = std::abs(truth.n_G.dot(member.p_W) - truth.d_G);
      ++counts[std::upper_bound(kLimits_m, kLimits_m + kBins - 1, distance_m) - kLimits_m];
      ++total;
    }
  }
  if (total == 0) {
    if (!members_.empty()) std::printf("landmarks on planes: none of them on a true plane\n");
    return;
  }
  std::printf("landmarks on planes: %d; truly off the plane that most of it are on by\n", total);
  const char* names[kBins] = {"< 3 mm", "3 to 10 mm", "10 to 20 mm", "20 to 30 mm", "more"};
  for (int k = 0; k < kBins; ++k)
    std::printf("  %-22s %7d %7.1f %%\n", names[k], counts[k], 100.0 * counts[k] / total);
}

}  // namespace facet
