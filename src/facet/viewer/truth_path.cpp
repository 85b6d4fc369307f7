// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/truth_path.h"

#include <algorithm>

#include "facet/eval/trajectory_error.h"

namespace facet {
namespace {

/// Whether the positions say how the estimate is turned.
bool HasMoved(std::span<const PosePair> pairs) {
  constexpr double kShortest_m = 0.1;
  return std::ranges::any_of(pairs, [&](const PosePair& pair) {
    return (pair.T_WB.p - pairs.front().T_WB.p).norm() > kShortest_m;
  });
}

SE3 AlignmentOf(std::span<const PosePair> pairs) {
  if (HasMoved(pairs)) return AlignPairs(pairs, AlignmentKind::kSE3).T_GW;
  return pairs.front().T_GB * pairs.front().T_WB.Inverse();
}

}  // namespace

std::optional<TruthPath> FindTruthPath(std::span<const StampedPose> estimate,
                                       std::span<const Timestamp> frames,
                                       std::span<const StampedPose> truth) {
  constexpr std::size_t kFewest = 3;
  const std::vector<PosePair> pairs = Associate(estimate, truth).pairs;
  if (pairs.size() < kFewest) return std::nullopt;
  std::vector<StampedPose> stamps;
  for (const Timestamp t : frames) {
    if (t >= estimate.front().t && t <= estimate.back().t) stamps.push_back({t, SE3()});
  }
  TruthPath path{AlignmentOf(pairs), {}};
  const SE3 T_WG = path.T_GW.Inverse();
  for (const PosePair& pair : Associate(stamps, truth).pairs)
    path.poses_W.push_back({pair.t, T_WG * pair.T_GB});
  return path;
}

}  // namespace facet
