// SPDX-License-Identifier: BSD-2-Clause
// Tells a real difference between two configurations from noise: runs are paired by their start,
// and the median ratio has an interval (bootstrap, Efron 1979).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "facet/eval/trajectory_error.h"

namespace facet {

/// ATE of several runs over the same frames of one recording.
struct CommonErrors {
  std::size_t num_frames = 0;
  std::vector<double> rmse_m, median_m;  ///< in the order of the runs
};

/// Every run is aligned on the frames that all of them have, and judged on those. Empty when there
/// are fewer than 3.
std::optional<CommonErrors> ErrorsOnCommonFrames(std::span<const std::vector<PosePair>> runs,
                                                 AlignmentKind alignment);

enum class Verdict {
  kReal,         ///< the interval excludes 1
  kNotShown,     ///< it does not
  kTooFewStarts  ///< fewer than 9 pairs
};
const char* ToString(Verdict verdict);

struct PairedComparison {
  std::vector<double> ratios;                  ///< other over reference, start by start
  double median_ratio = 1, low = 1, high = 1;  ///< with its 95 % interval
  int num_better = 0;                          ///< ratios below 1
  Verdict verdict = Verdict::kTooFewStarts;
};

inline constexpr int kMinStartsForVerdict = 9;

/// The interval is that of the bootstrap, widened to the order statistics between which the median
/// lies with 95 % probability whatever the distribution: for some numbers of starts (11, 13) the
/// bootstrap of a median alone covers only 92 to 94 %. The same ratios give the same interval: the
/// seed is fixed. At least one ratio.
PairedComparison CompareRatios(std::vector<double> ratios,
                               int num_rounds = 10000,
                               std::uint64_t seed = 1);

}  // namespace facet
