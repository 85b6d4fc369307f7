// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/plane_budget.h"

#include <algorithm>
#include <tuple>

#include <Eigen/LU>

#include "facet/estimator/plane_membership.h"

namespace facet {

std::vector<PlaneId> ExcessPlanes(const SlidingWindow& window,
                                  const std::vector<Matrix3d>& information,
                                  int max_planes) {
  const int num_excess = static_cast<int>(window.planes.size()) - max_planes;
  if (num_excess <= 0) return {};
  std::vector<Matrix3d> known = information;
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    if (!block.IsPlane()) continue;
    known[static_cast<std::size_t>(window.IndexOf(block.plane))] +=
        window.prior.H.block<3, 3>(block.offset, block.offset);
  }
  // Ascending: the first go. The determinant does not depend on where the anchor is.
  struct Rank {
    bool is_supported;
    double determinant;
    PlaneId id;
    auto Key() const { return std::tie(is_supported, determinant, id); }
  };
  const std::vector<int> members = CountMembers(window);
  std::vector<Rank> ranks;
  for (std::size_t k = 0; k < window.planes.size(); ++k)
    ranks.push_back({members[k] > 0, known[k].determinant(), window.planes[k].id});
  std::sort(
      ranks.begin(), ranks.end(), [](const Rank& a, const Rank& b) { return a.Key() < b.Key(); });
  std::vector<PlaneId> excess;
  for (int k = 0; k < num_excess; ++k)
    excess.push_back(ranks[static_cast<std::size_t>(k)].id);
  return excess;
}

}  // namespace facet
