// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_budget.h"

#include <algorithm>
#include <tuple>

#include <Eigen/LU>

namespace facet {

namespace {
constexpr int kSharePerChance = 10;  // one plane in so many may be one that is not known well yet
}  // namespace

std::vector<PlaneId> ExcessPlanes(const SlidingWindow& window,
                                  const std::vector<Matrix3d>& information,
                                  int max_planes) {
  const int num_excess = static_cast<int>(window.planes.size()) - max_planes;
  if (num_excess <= 0) return {};
  std::vector<Matrix3d> known = information;
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    if (block.kind != Variable::Kind::kPlane) continue;
    known[static_cast<std::size_t>(window.IndexOf(block.plane))] +=
        window.prior.H.block<3, 3>(block.offset, block.offset);
  }
  struct Rank {
    double determinant;  // does not depend on where the anchor is
    PlaneId id;
    bool is_new;  // in view, and not yet known well
    bool has_chance = false;
    auto Key() const { return std::tie(determinant, id); }
  };
  const std::vector<int> num_landmarks = window.CountPlaneLandmarks();
  std::vector<Rank> ranks;
  for (std::size_t k = 0; k < window.planes.size(); ++k) {
    const WindowPlane& plane = window.planes[k];
    ranks.push_back({known[k].determinant(), plane.id, num_landmarks[k] > 0 && !plane.persistent});
  }
  std::sort(
      ranks.begin(), ranks.end(), [](const Rank& a, const Rank& b) { return a.Key() < b.Key(); });
  int num_chances = std::max(1, max_planes / kSharePerChance);
  for (auto rank = ranks.rbegin(); rank != ranks.rend(); ++rank)
    rank->has_chance = rank->is_new && num_chances-- > 0;
  std::stable_partition(
      ranks.begin(), ranks.end(), [](const Rank& rank) { return !rank.has_chance; });
  std::vector<PlaneId> excess;
  for (int k = 0; k < num_excess; ++k)
    excess.push_back(ranks[static_cast<std::size_t>(k)].id);
  return excess;
}

}  // namespace facet
