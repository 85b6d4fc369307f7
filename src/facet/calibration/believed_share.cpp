// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/believed_share.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "facet/calibration/relative_covariance.h"

namespace facet {
namespace {

constexpr double kBelievedAsGiven = 0.9;
constexpr double kLeastShare = 0.01;
constexpr int kNumShares = 15;            // shares are told apart by a factor of 1.4
constexpr double kLeastVariance = 1e-12;  // of the first one; less is rounding

/// What the measurements alone say of one direction, of which the first variance is 1.
struct Direction {
  double information;
  double gradient;  ///< information times what they say the deviation is
};

/// Directions that are independent, before the measurements and after them.
std::optional<std::vector<Direction>> MeasuredDirections(const MatrixXd& first,
                                                         const GroupEstimate& estimate) {
  const auto relative = RelativeCovariance<MatrixXd>::Of(first, estimate.covariance);
  if (!relative || !(relative->shares()(0) > 0) || !estimate.mean.allFinite()) return std::nullopt;
  const VectorXd along = relative->Along(estimate.mean);
  std::vector<Direction> directions;
  for (int i = 0; i < along.size(); ++i) {
    const double variance = std::max(relative->shares()(i), kLeastVariance);
    directions.push_back({std::max(1 / variance - 1 / estimate.share, 0.0), along(i) / variance});
  }
  return directions;
}

/// Logarithm of the probability of what was measured, up to a constant.
double LogEvidence(const std::vector<Direction>& directions, double share) {
  double sum = 0;
  for (const auto& [information, gradient] : directions) {
    const double growth = 1 + share * information;
    sum += 0.5 * (gradient * gradient * share / growth - std::log(growth));
  }
  return sum;
}

}  // namespace

double BelievedShare(const MatrixXd& first, const GroupEstimate& estimate) {
  const auto directions = MeasuredDirections(first, estimate);
  if (!directions) return estimate.share;
  std::array<double, kNumShares> shares, evidence;
  for (std::size_t i = 0; i < kNumShares; ++i) {
    shares[i] = std::pow(kLeastShare, static_cast<double>(i) / (kNumShares - 1));
    evidence[i] = LogEvidence(*directions, shares[i]);
  }
  const double best = *std::max_element(evidence.begin(), evidence.end());
  double sum = 0, weighted = 0;
  for (std::size_t i = 0; i < kNumShares; ++i) {
    const double before = i == 0 ? kBelievedAsGiven : (1 - kBelievedAsGiven) / (kNumShares - 1);
    const double probability = before * std::exp(evidence[i] - best);
    sum += probability;
    weighted += probability * shares[i];
  }
  return weighted / sum;
}

}  // namespace facet
