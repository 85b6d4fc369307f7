// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/paired_comparison.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "facet/base/check.h"
#include "facet/base/random.h"

namespace facet {
namespace {

double Median(std::vector<double>& values) {
  const std::size_t n = values.size();
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

// Linear between the two nearest ranks.
double Quantile(const std::vector<double>& sorted, double share) {
  const double rank = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  const double fraction = rank - static_cast<double>(below);
  return (1 - fraction) * sorted[below] + fraction * sorted[above];
}

// How many of n values may be left out at each end so that the rest still spans the median with 95
// % probability: each value lies below it with probability 1/2.
std::size_t NumLeftOut(std::size_t n) {
  double probability = std::pow(0.5, n), below = 0;  // of exactly, and of at most k values below
  std::size_t k = 0;
  while (2 * (below + probability) <= 0.05) {
    below += probability;
    probability *= static_cast<double>(n - k) / static_cast<double>(k + 1);
    ++k;
  }
  return k == 0 ? 0 : k - 1;
}

std::vector<Timestamp> StampsOf(const std::vector<PosePair>& pairs) {
  std::vector<Timestamp> stamps;
  for (const PosePair& pair : pairs)
    stamps.push_back(pair.t);
  return stamps;
}

std::vector<Timestamp> CommonStamps(std::span<const std::vector<PosePair>> runs) {
  std::vector<Timestamp> common = StampsOf(runs.front());
  for (const auto& run : runs.subspan(1)) {
    std::vector<Timestamp> both;
    std::ranges::set_intersection(common, StampsOf(run), std::back_inserter(both));
    common = std::move(both);
  }
  return common;
}

std::vector<PosePair> Restrict(const std::vector<PosePair>& pairs,
                               const std::vector<Timestamp>& stamps) {
  std::vector<PosePair> kept;
  for (const PosePair& pair : pairs) {
    if (std::ranges::binary_search(stamps, pair.t)) kept.push_back(pair);
  }
  return kept;
}

}  // namespace

std::optional<CommonErrors> ErrorsOnCommonFrames(std::span<const std::vector<PosePair>> runs,
                                                 AlignmentKind alignment) {
  if (runs.empty()) return std::nullopt;
  const std::vector<Timestamp> stamps = CommonStamps(runs);
  if (stamps.size() < 3) return std::nullopt;
  CommonErrors errors;
  errors.num_frames = stamps.size();
  for (const auto& run : runs) {
    const std::vector<PosePair> pairs = Restrict(run, stamps);
    const ErrorStatistics ate = Summarize(AbsoluteErrors(pairs, AlignPairs(pairs, alignment)));
    errors.rmse_m.push_back(ate.rmse);
    errors.median_m.push_back(ate.median);
  }
  return errors;
}

const char* ToString(Verdict verdict) {
  switch (verdict) {
    case Verdict::kReal:
      return "real";
    case Verdict::kNotShown:
      return "no difference shown";
    case Verdict::kTooFewStarts:
      return "needs 9 starts to judge";
  }
  return "";
}

PairedComparison CompareRatios(std::vector<double> ratios, int num_rounds, std::uint64_t seed) {
  FACET_CHECK(!ratios.empty()) << "a comparison of nothing";
  PairedComparison result;
  result.ratios = ratios;
  const int n = static_cast<int>(ratios.size());
  Rng rng(seed);
  std::vector<double> medians, drawn(ratios.size());
  for (int round = 0; round < num_rounds; ++round) {
    for (double& value : drawn)
      value = ratios[rng.Index(n)];
    medians.push_back(Median(drawn));
  }
  std::sort(medians.begin(), medians.end());
  result.low = Quantile(medians, 0.025);
  result.high = Quantile(medians, 0.975);
  result.num_better =
      static_cast<int>(std::ranges::count_if(ratios, [](double r) { return r < 1; }));
  result.median_ratio = Median(ratios);  // sorts them
  const std::size_t left_out = NumLeftOut(ratios.size());
  result.low = std::min(result.low, ratios[left_out]);
  result.high = std::max(result.high, ratios[ratios.size() - 1 - left_out]);
  if (n >= kMinStartsForVerdict) {
    const bool excludes_one = result.low > 1 || result.high < 1;
    result.verdict = excludes_one ? Verdict::kReal : Verdict::kNotShown;
  }
  return result;
}

}  // namespace facet
