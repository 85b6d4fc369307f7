// SPDX-License-Identifier: BSD-2-Clause
// How often each spot of a plane has said where the plane is. What a spot says is wrong by the same
// amount every time: it stands out from the surface, and the patch that is tracked there sits where
// it sits. A camera that stays in one place would otherwise hear the same few hundred spots again
// and again and believe each time that it learns something.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "facet/estimator/window/marginalization_plan.h"

namespace facet {

/// A spot is where the ray to a landmark meets the plane, and has the size at which corners keep
/// apart from each other. It is a place in the world: if the estimate has drifted by more than that
/// size, what is seen there is news, about the drift.
///
/// A row of a spot from which the prior has k has 2 k + 1 times the sigma, so that all of them
/// together say at most pi^2 / 8 as much as the first. Bounded memory for each plane (32 kB): where
/// too many spots share a place of the table, the one that was heard least is forgotten. Not
/// thread-safe.
class PlaneEvidence {
 public:
  /// By how much the sigma of the row is to be multiplied with which this landmark joins the plane
  /// with this index.
  double RowScale(const SlidingWindow& window, const WindowLandmark& landmark, int plane) const;

  /// The rows of the landmarks that are about to be marginalised are used up; planes that are not
  /// in the window any more are forgotten.
  void UseUp(const MarginalizationPlan& plan, const SlidingWindow& window);

 private:
  struct Spot {
    std::uint32_t tag = 0;          ///< which spot it is; 0: none
    std::uint32_t num_used_up = 0;  ///< rows that the prior has
  };
  static constexpr std::size_t kNumSets = 1024, kSpotsPerSet = 4;

  void Count(const SlidingWindow& window, const WindowLandmark& landmark, int plane);

  std::map<PlaneId, std::vector<Spot>> spots_;  // sets of kSpotsPerSet, one after the other
};

}  // namespace facet
