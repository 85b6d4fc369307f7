// SPDX-License-Identifier: BSD-2-Clause
#include "plane_members.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace facet {

PlaneMembers::PlaneMembers(const std::filesystem::path& sequence)
    : planes_G_(ReadTruePlanes(sequence / "truth" / "planes.csv")) {}

void PlaneMembers::Add(const MapSnapshot& map) {
  for (const LandmarkEstimate& landmark : map.landmarks) {
    if (!points_.contains(landmark.id)) continue;
    for (const PlaneId plane : landmark.planes) {
      if (plane.IsValid()) members_[plane].insert(landmark.id);
    }
  }
}

int PlaneMembers::TruePlaneOf(const std::set<LandmarkId>& members) const {
  std::map<int, int> votes;
  for (const LandmarkId landmark : members) {
    if (const int plane = points_.at(landmark).plane; plane >= 0) ++votes[plane];
  }
  const auto most = std::max_element(
      votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == votes.end() ? -1 : most->first;
}

void PlaneMembers::Print() const {
  constexpr double kLimits_m[] = {0.003, 0.01, 0.02, 0.03};
  constexpr int kBins = 5;
  int counts[kBins] = {}, total = 0;
  for (const auto& [id, members] : members_) {
    const int plane = TruePlaneOf(members);
    if (plane < 0) continue;
    const TruePlane& truth = planes_G_[static_cast<std::size_t>(plane)];
    for (const LandmarkId landmark : members) {
      const double distance_m = std::abs(truth.n_G.dot(points_.at(landmark).p_W) - truth.d_G);
      ++counts[std::upper_bound(kLimits_m, kLimits_m + kBins - 1, distance_m) - kLimits_m];
      ++total;
    }
  }
  if (total == 0) return;
  std::printf("landmarks on planes: %d; truly off the plane that most of it are on by\n", total);
  const char* names[kBins] = {"< 3 mm", "3 to 10 mm", "10 to 20 mm", "20 to 30 mm", "more"};
  for (int k = 0; k < kBins; ++k)
    std::printf("  %-22s %7d %7.1f %%\n", names[k], counts[k], 100.0 * counts[k] / total);
}

}  // namespace facet
