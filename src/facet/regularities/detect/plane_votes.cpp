// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/plane_votes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace facet {

namespace {

constexpr double kMaxRange_m = 100;
constexpr double kBinsPerSigma = 1.5;
constexpr double kReach = 2.5;  // of a bump, in sigmas
constexpr float kChanged = -1;
constexpr int kAzimuths = 60;
constexpr double kAzimuthStep = std::numbers::pi / kAzimuths;

// Samples of a bump of height 1, at distances of whole bins, for the fractions k / kPhases of a bin
// by which its middle lies behind the first sample's bin.
constexpr int kPhases = 16;
constexpr int kHalfTaps = 4;
constexpr int kTaps = 2 * kHalfTaps;

using Bump = std::array<float, kTaps>;

std::array<Bump, kPhases> MakeBumps() {
  std::array<Bump, kPhases> bumps;
  for (int phase = 0; phase < kPhases; ++phase) {
    for (int tap = 0; tap < kTaps; ++tap) {
      const double x = (tap - kHalfTaps + 1 - static_cast<double>(phase) / kPhases) / kBinsPerSigma;
      bumps[phase][tap] = static_cast<float>(std::exp(-0.5 * x * x));
    }
  }
  return bumps;
}

// Adds a bump of the given height around `position`, in bins.
void AddBump(double position, double weight, float* bins, int num_bins) {
  static const std::array<Bump, kPhases> kBumps = MakeBumps();
  if (!(position > -kTaps && position < num_bins + kTaps) || !std::isfinite(weight)) return;
  // Counted from where it is positive, so that truncation rounds down.
  const auto fine = static_cast<unsigned>((position + kTaps) * kPhases + 0.5);
  const Bump& bump = kBumps[fine % kPhases];
  const int start = static_cast<int>(fine / kPhases) - kTaps - kHalfTaps + 1;
  const auto height = static_cast<float>(weight);
  if (start >= 0 && start + kTaps <= num_bins) {
    using Taps = Eigen::Array<float, kTaps, 1>;
    Eigen::Map<Taps>(bins + start) += height * Eigen::Map<const Taps>(bump.data());
    return;
  }
  for (int tap = std::max(0, -start); tap < std::min(kTaps, num_bins - start); ++tap)
    bins[start + tap] += height * bump[static_cast<std::size_t>(tap)];
}

// Vertex of the parabola through the bin and its neighbours, relative to the bin.
double PeakOffset(const float* bins, int num_bins, int k) {
  if (k == 0 || k == num_bins - 1) return 0;
  const double curvature = bins[k - 1] - 2 * bins[k] + bins[k + 1];
  return curvature < 0 ? 0.5 * (bins[k - 1] - bins[k + 1]) / curvature : 0;
}

void EraseAround(double position, float* bins, int num_bins) {
  const int middle = static_cast<int>(std::lround(position));
  const int first = std::clamp(middle - kHalfTaps, 0, num_bins);
  const int last = std::clamp(middle + kHalfTaps + 1, first, num_bins);
  std::fill(bins + first, bins + last, 0.0F);
}

}  // namespace

void HeightVotes::Reset(double min_m, double max_m, double sigma_m) {
  const double middle = 0.5 * (min_m + max_m);
  const double half = std::min(0.5 * (max_m - min_m) + kReach * sigma_m, kMaxRange_m);
  bin_m_ = sigma_m / kBinsPerSigma;
  origin_m_ = middle - half;
  bins_.assign(static_cast<std::size_t>(2 * half / bin_m_) + 2, 0.0F);
}

void HeightVotes::Add(double height_m, double weight) {
  AddBump((height_m - origin_m_) / bin_m_, weight, bins_.data(), static_cast<int>(bins_.size()));
}

std::optional<VotePeak> HeightVotes::Highest() const {
  const auto highest = std::max_element(bins_.begin(), bins_.end());
  if (highest == bins_.end() || *highest <= 0) return std::nullopt;
  const int k = static_cast<int>(highest - bins_.begin());
  const double position = k + PeakOffset(bins_.data(), static_cast<int>(bins_.size()), k);
  return VotePeak{{Vector3d::UnitZ(), origin_m_ + bin_m_ * position}, *highest};
}

void HeightVotes::Erase(const Plane& plane_W) {
  EraseAround((plane_W.d - origin_m_) / bin_m_, bins_.data(), static_cast<int>(bins_.size()));
}

void WallVotes::Reset(const Vector3d& origin_W, double radius_m, double sigma_m, double sigma_rad) {
  origin_W_ = origin_W;
  sigma_rad_ = sigma_rad;
  decay_ = std::exp(-kAzimuthStep * kAzimuthStep / (sigma_rad * sigma_rad));
  bin_m_ = sigma_m / kBinsPerSigma;
  radius_m_ = std::min(radius_m, kMaxRange_m) + kReach * sigma_m;
  num_distances_ = static_cast<int>(2 * radius_m_ / bin_m_) + 2;
  bins_.assign(static_cast<std::size_t>(kAzimuths * num_distances_), 0.0F);
  highest_.assign(kAzimuths, 0.0F);
  if (!directions_.empty()) return;
  for (int k = 0; k < kAzimuths; ++k)
    directions_.emplace_back(std::cos(k * kAzimuthStep), std::sin(k * kAzimuthStep), 0);
}

void WallVotes::AddColumn(int column, double distance_m, double weight) {
  highest_[column] = kChanged;
  AddBump((distance_m + radius_m_) / bin_m_,
          weight,
          bins_.data() + column * num_distances_,
          num_distances_);
}

// `distance` is asked for that of the vote in a column, whose direction it gets.
template <class Distance>
void WallVotes::AddBumps(const Vector3d& n_W, double weight, const Distance& distance) {
  if (!n_W.allFinite()) return;
  const double azimuth = std::atan2(n_W.y(), n_W.x());
  const double reach = kReach * sigma_rad_;
  const int first = static_cast<int>(std::ceil((azimuth - reach) / kAzimuthStep));
  const int last = static_cast<int>(std::floor((azimuth + reach) / kAzimuthStep));
  // Samples of a Gaussian: their ratios are a geometric series.
  const double x = (first * kAzimuthStep - azimuth) / sigma_rad_, step = kAzimuthStep / sigma_rad_;
  double height = weight * std::exp(-0.5 * x * x);
  double ratio = std::exp(-step * (x + 0.5 * step));
  for (int k = first; k <= last; ++k) {
    // Azimuth and azimuth + pi are the same wall, its distance then has the other sign: the
    // column's own direction takes care of that.
    const int column = ((k % kAzimuths) + kAzimuths) % kAzimuths;
    AddColumn(column, distance(directions_[column]), height);
    height *= ratio;
    ratio *= decay_;
  }
}

void WallVotes::Add(const Vector3d& centre_W, const Vector3d& n_W, double weight) {
  AddBumps(
      n_W, weight, [&](const Vector3d& direction) { return direction.dot(centre_W - origin_W_); });
}

void WallVotes::AddOwnDistance(const Vector3d& centre_W, const Vector3d& n_W, double weight) {
  const Vector3d level = Vector3d(n_W.x(), n_W.y(), 0).normalized();
  const double distance = level.dot(centre_W - origin_W_);
  AddBumps(n_W, weight, [&](const Vector3d& direction) {
    return direction.dot(level) < 0 ? -distance : distance;
  });
}

std::optional<VotePeak> WallVotes::Highest() {
  for (std::size_t k = 0; k < highest_.size(); ++k) {
    if (highest_[k] >= 0) continue;
    const float* row = bins_.data() + k * static_cast<std::size_t>(num_distances_);
    highest_[k] = std::max(0.0F, Eigen::Map<const Eigen::ArrayXf>(row, num_distances_).maxCoeff());
  }
  const auto highest = std::max_element(highest_.begin(), highest_.end());
  if (highest == highest_.end() || *highest <= 0) return std::nullopt;
  const int column = static_cast<int>(highest - highest_.begin());
  const float* row = bins_.data() + column * num_distances_;
  const int k = static_cast<int>(std::find(row, row + num_distances_, *highest) - row);
  const double distance = bin_m_ * (k + PeakOffset(row, num_distances_, k)) - radius_m_;
  const Vector3d& n = directions_[column];
  return VotePeak{{n, distance + n.dot(origin_W_)}, *highest};
}

void WallVotes::Erase(const Plane& plane_W) {
  const double azimuth = std::atan2(plane_W.n.y(), plane_W.n.x());
  const int column =
      ((static_cast<int>(std::lround(azimuth / kAzimuthStep)) % kAzimuths) + kAzimuths) % kAzimuths;
  const Vector3d& n = directions_[column];
  const double sign = n.dot(plane_W.n) < 0 ? -1 : 1;
  const double distance = sign * (plane_W.d - plane_W.n.dot(origin_W_));
  highest_[column] = kChanged;
  EraseAround(
      (distance + radius_m_) / bin_m_, bins_.data() + column * num_distances_, num_distances_);
}

}  // namespace facet
