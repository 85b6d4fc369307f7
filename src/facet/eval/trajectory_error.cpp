// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/trajectory_error.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "facet/base/check.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

constexpr std::size_t kMinPairs = 3;
constexpr Duration kSmallestTruthGap{100'000'000};

Duration LongestInterpolation(std::span<const StampedPose> truth) {
  if (truth.size() < 2) return kSmallestTruthGap;
  std::vector<double> intervals_ns;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    intervals_ns.push_back(static_cast<double>((truth[i].t - truth[i - 1].t).ns));
  }
  const auto median_ns = static_cast<std::int64_t>(Summarize(std::move(intervals_ns)).median);
  return std::max(kSmallestTruthGap, Duration{3 * median_ns});
}

SE3 Interpolate(const StampedPose& a, const StampedPose& b, Timestamp t) {
  const double s = static_cast<double>((t - a.t).ns) / static_cast<double>((b.t - a.t).ns);
  return {a.T_WB.q.slerp(s, b.T_WB.q), (1 - s) * a.T_WB.p + s * b.T_WB.p};
}

// Path along the truth from the first pair to each pair.
std::vector<double> TravelledDistance(std::span<const PosePair> pairs) {
  std::vector<double> travelled(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    travelled[i] = travelled[i - 1] + (pairs[i].T_GB.p - pairs[i - 1].T_GB.p).norm();
  }
  return travelled;
}

// Index after `first` whose value is closest to target, the earliest of equals; values ascend.
std::size_t ClosestAfter(const std::vector<double>& values, std::size_t first, double target) {
  const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first) + 1;
  const auto above = std::lower_bound(begin, values.end(), target);
  if (above == begin) return first + 1;
  const double value_below = *std::prev(above);
  const auto below = std::lower_bound(begin, above, value_below);
  const bool take_below = above == values.end() || target - value_below <= *above - target;
  return static_cast<std::size_t>((take_below ? below : above) - values.begin());
}

// Umeyama's scale takes the estimate to the truth; the error is that of the estimate.
std::optional<double> ScaleErrorPercent(std::span<const PosePair> pairs, double path_length_m) {
  const double scale = AlignPairs(pairs, AlignmentKind::kSim3).scale;
  if (path_length_m <= 0 || scale <= 0) return std::nullopt;
  return 100.0 * (1.0 / scale - 1.0);
}

std::optional<double> DriftPercent(std::span<const RelativeErrors> rpe) {
  double sum = 0;
  std::size_t count = 0;
  for (const RelativeErrors& errors : rpe) {
    for (double e : errors.translation_m) {
      sum += e / errors.length_m;
    }
    count += errors.translation_m.size();
  }
  if (count == 0) return std::nullopt;
  return 100.0 * sum / static_cast<double>(count);
}

std::string SpanText(std::span<const StampedPose> poses) {
  return FormatSeconds(poses.front().t) + " to " + FormatSeconds(poses.back().t) + " s";
}

// Tells stamps that are a power of a thousand apart from recordings of different days.
std::string UnitHint(Timestamp a, Timestamp b) {
  const double larger = static_cast<double>(std::max(a.ns, b.ns));
  const double smaller = static_cast<double>(std::min(a.ns, b.ns));
  if (smaller <= 0) return "";
  for (double factor : {1e3, 1e6, 1e9}) {
    if (std::abs(larger / smaller / factor - 1) < 0.01) {
      return "; the stamps differ by a power of a thousand: one file has another unit of time";
    }
  }
  return "";
}

}  // namespace

Association Associate(std::span<const StampedPose> estimate, std::span<const StampedPose> truth) {
  Association result;
  const Duration max_gap = LongestInterpolation(truth);
  for (const StampedPose& pose : estimate) {
    const auto after = std::ranges::lower_bound(truth, pose.t, {}, &StampedPose::t);
    if (after != truth.end() && after->t == pose.t) {
      result.pairs.push_back({pose.t, pose.T_WB, after->T_WB});
    } else if (after == truth.begin() || after == truth.end()) {
      ++result.num_outside;
    } else if (after->t - std::prev(after)->t > max_gap) {
      ++result.num_in_gaps;
    } else {
      result.pairs.push_back({pose.t, pose.T_WB, Interpolate(*std::prev(after), *after, pose.t)});
    }
  }
  return result;
}

ErrorStatistics Summarize(std::vector<double> errors) {
  FACET_CHECK(!errors.empty()) << "statistics of nothing";
  std::sort(errors.begin(), errors.end());
  const std::size_t n = errors.size();
  const double count = static_cast<double>(n);
  ErrorStatistics s;
  s.mean = std::accumulate(errors.begin(), errors.end(), 0.0) / count;
  s.rmse = std::sqrt(std::inner_product(errors.begin(), errors.end(), errors.begin(), 0.0) / count);
  s.median = n % 2 == 1 ? errors[n / 2] : 0.5 * (errors[n / 2 - 1] + errors[n / 2]);
  s.max = errors.back();
  return s;
}

TrajectoryAlignment AlignPairs(std::span<const PosePair> pairs, AlignmentKind kind) {
  std::vector<Vector3d> p_W, p_G;
  for (const PosePair& pair : pairs) {
    p_W.push_back(pair.T_WB.p);
    p_G.push_back(pair.T_GB.p);
  }
  return AlignTrajectory(p_W, p_G, kind);
}

std::vector<double> AbsoluteErrors(std::span<const PosePair> pairs,
                                   const TrajectoryAlignment& alignment) {
  std::vector<double> errors;
  errors.reserve(pairs.size());
  for (const PosePair& pair : pairs) {
    errors.push_back((pair.T_GB.p - alignment * pair.T_WB.p).norm());
  }
  return errors;
}

RelativeErrors ComputeRelativeErrors(std::span<const PosePair> pairs,
                                     double length_m,
                                     double tolerance) {
  RelativeErrors result;
  result.length_m = length_m;
  const std::vector<double> travelled = TravelledDistance(pairs);
  for (std::size_t i = 0; i + 1 < pairs.size(); ++i) {
    const double target = travelled[i] + length_m;
    const std::size_t j = ClosestAfter(travelled, i, target);
    if (std::abs(travelled[j] - target) > tolerance * length_m) continue;
    const SE3 estimate = pairs[i].T_WB.Inverse() * pairs[j].T_WB;
    const SE3 truth = pairs[i].T_GB.Inverse() * pairs[j].T_GB;
    const SE3 error = estimate.Inverse() * truth;
    result.translation_m.push_back(error.p.norm());
    result.rotation_rad.push_back(LogSO3(error.q).norm());
  }
  return result;
}

std::vector<double> DefaultRpeLengths(double path_length_m) {
  std::vector<double> lengths;
  const auto add_while_it_fits = [&](double length) {
    if (length <= 0.95 * path_length_m) lengths.push_back(length);
  };
  for (double length : {1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 100.0, 200.0, 500.0, 1000.0}) {
    add_while_it_fits(length);
  }
  if (!lengths.empty()) return lengths;
  for (double length : {0.1, 0.2, 0.5}) {
    add_while_it_fits(length);
  }
  return lengths;
}

std::string WhatIsWrong(std::span<const StampedPose> estimate, std::span<const StampedPose> truth) {
  if (estimate.empty()) return "the trajectory holds no pose";
  if (truth.empty()) return "the ground truth holds no pose";
  const Association association = Associate(estimate, truth);
  if (association.pairs.size() >= kMinPairs) return "";
  if (estimate.size() < kMinPairs) {
    return "the trajectory has " + std::to_string(estimate.size()) +
           " poses; at least 3 are needed";
  }
  if (estimate.back().t < truth.front().t || estimate.front().t > truth.back().t) {
    return "no overlap in time: the trajectory covers " + SpanText(estimate) +
           ", the ground truth " + SpanText(truth) + UnitHint(estimate.front().t, truth.front().t);
  }
  return "only " + std::to_string(association.pairs.size()) + " of " +
         std::to_string(estimate.size()) + " poses have a ground truth (" +
         std::to_string(association.num_outside) + " are outside it, " +
         std::to_string(association.num_in_gaps) + " in holes of it); at least 3 are needed";
}

TrajectoryError EvaluateTrajectory(std::span<const StampedPose> estimate,
                                   std::span<const StampedPose> truth,
                                   const TrajectoryErrorOptions& options) {
  const std::string problem = WhatIsWrong(estimate, truth);
  FACET_CHECK(problem.empty()) << problem;
  const Association association = Associate(estimate, truth);
  const std::vector<PosePair>& pairs = association.pairs;

  TrajectoryError result;
  result.num_pairs = static_cast<int>(pairs.size());
  result.num_outside = association.num_outside;
  result.num_in_gaps = association.num_in_gaps;
  result.path_length_m = TravelledDistance(pairs).back();
  result.alignment = AlignPairs(pairs, options.alignment);
  result.ate_m = Summarize(AbsoluteErrors(pairs, result.alignment));
  const std::vector<double> lengths = options.rpe_lengths_m.empty()
                                          ? DefaultRpeLengths(result.path_length_m)
                                          : options.rpe_lengths_m;
  for (double length : lengths) {
    RelativeErrors errors = ComputeRelativeErrors(pairs, length);
    if (!errors.translation_m.empty()) result.rpe.push_back(std::move(errors));
  }
  result.drift_percent = DriftPercent(result.rpe);
  result.scale_error_percent = ScaleErrorPercent(pairs, result.path_length_m);
  return result;
}

}  // namespace facet
