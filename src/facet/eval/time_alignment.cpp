// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/time_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace facet {
namespace {

constexpr Duration kCoarseStep{10'000'000};
constexpr std::int64_t kFinestNs = 1000;
constexpr double kMinShare = 0.5;  // of the pairs without offset: few pairs fit anything

struct Fit {
  double rmse = std::numeric_limits<double>::infinity();
  std::size_t num_pairs = 0;
};

class OffsetSearch {
 public:
  OffsetSearch(std::span<const StampedPose> estimate,
               std::span<const StampedPose> truth,
               AlignmentKind kind)
      : estimate_(estimate), truth_(truth), kind_(kind) {}

  Fit At(std::int64_t offset_ns) const {
    const Association association = Associate(ShiftInTime(estimate_, {offset_ns}), truth_);
    Fit fit;
    fit.num_pairs = association.pairs.size();
    if (fit.num_pairs < 3) return fit;
    const TrajectoryAlignment alignment = AlignPairs(association.pairs, kind_);
    fit.rmse = Summarize(AbsoluteErrors(association.pairs, alignment)).rmse;
    return fit;
  }

  // Golden section: the error is a smooth valley within one coarse step around its least value.
  std::int64_t Refine(std::int64_t low, std::int64_t high) const {
    constexpr double kGolden = 0.6180339887498949;
    const auto inside = [&](double share) {
      return low + std::llround(share * static_cast<double>(high - low));
    };
    while (high - low > kFinestNs) {
      const std::int64_t a = inside(1 - kGolden), b = inside(kGolden);
      (At(a).rmse <= At(b).rmse ? high : low) = At(a).rmse <= At(b).rmse ? b : a;
    }
    return (low + high) / 2;
  }

 private:
  std::span<const StampedPose> estimate_, truth_;
  AlignmentKind kind_;
};

}  // namespace

Duration EstimateTimeOffset(std::span<const StampedPose> estimate,
                            std::span<const StampedPose> truth,
                            AlignmentKind alignment,
                            Duration max_offset) {
  const OffsetSearch search(estimate, truth, alignment);
  std::vector<std::pair<std::int64_t, Fit>> fits;
  std::size_t most_pairs = 0;
  const std::int64_t num_steps = max_offset.ns / kCoarseStep.ns;
  for (std::int64_t k = -num_steps; k <= num_steps; ++k) {
    fits.emplace_back(k * kCoarseStep.ns, search.At(k * kCoarseStep.ns));
    most_pairs = std::max(most_pairs, fits.back().second.num_pairs);
  }
  std::int64_t best_ns = 0;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [offset_ns, fit] : fits) {
    if (static_cast<double>(fit.num_pairs) < kMinShare * static_cast<double>(most_pairs)) continue;
    if (fit.rmse >= least) continue;
    least = fit.rmse;
    best_ns = offset_ns;
  }
  if (!std::isfinite(least)) return {0};
  return {search.Refine(best_ns - kCoarseStep.ns, best_ns + kCoarseStep.ns)};
}

std::vector<StampedPose> ShiftInTime(std::span<const StampedPose> poses, Duration offset) {
  std::vector<StampedPose> shifted(poses.begin(), poses.end());
  for (StampedPose& pose : shifted)
    pose.t = pose.t + offset;
  return shifted;
}

}  // namespace facet
