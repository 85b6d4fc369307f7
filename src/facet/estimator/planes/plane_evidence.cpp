// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_evidence.h"

#include <algorithm>
#include <cmath>

namespace facet {

namespace {

// Angle between neighbouring corners [rad]: 16 pixels of usual cameras.
constexpr double kSpot_rad = 0.035;

std::uint64_t Mixed(std::uint64_t x) {  // finaliser of MurmurHash3, public domain
  x ^= x >> 33;
  x *= 0xff51afd7ed558ccdULL;
  x ^= x >> 33;
  x *= 0xc4ceb9fe1a85ec53ULL;
  return x ^ (x >> 33);
}

// The plane is cut into squares by two axes of the world, those across which it does not run; their
// side is the power of two nearest to the size of the spot.
std::uint64_t KeyOf(const Vector3d& at_W, const Vector3d& n, double distance_m) {
  const double level = std::round(std::log2(kSpot_rad * distance_m));
  const double side_m = std::exp2(level);
  int across = 0;
  n.cwiseAbs().maxCoeff(&across);
  std::uint64_t key = Mixed(static_cast<std::uint64_t>(static_cast<std::int64_t>(3 * level)) +
                            static_cast<std::uint64_t>(across));
  for (int k = 1; k <= 2; ++k) {
    const double cell = std::floor(at_W((across + k) % 3) / side_m);
    key = Mixed(key ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(cell)));
  }
  return key;
}

std::uint64_t SpotOf(const SlidingWindow& window, const WindowLandmark& landmark, int plane) {
  const WindowPlane& on = window.planes[plane];
  const Vector3d camera_W = window.LeftCameraAt(landmark.host).p;
  const Vector3d p_W = window.PositionOf(landmark);
  // How much farther along the ray the plane is; a ray that hardly meets it does not count.
  const double farther = -on.SignedDistance(p_W) / on.n.dot(p_W - camera_W);
  const bool meets = std::abs(farther) < 0.5;
  const Vector3d at_W = meets ? Vector3d(p_W + farther * (p_W - camera_W)) : p_W;
  return KeyOf(at_W, on.n, 1 / landmark.inverse_distance);
}

std::uint32_t TagOf(std::uint64_t key) {
  return static_cast<std::uint32_t>(key >> 32) | 1U;
}

}  // namespace

double PlaneEvidence::RowScale(const SlidingWindow& window,
                               const WindowLandmark& landmark,
                               int plane) const {
  const auto table = spots_.find(window.planes[plane].id);
  if (table == spots_.end()) return 1;
  const std::uint64_t key = SpotOf(window, landmark, plane);
  const Spot* const set = &table->second[key % kNumSets * kSpotsPerSet];
  for (std::size_t k = 0; k < kSpotsPerSet; ++k) {
    if (set[k].tag == TagOf(key)) return 1 + 2.0 * set[k].num_used_up;
  }
  return 1;
}

void PlaneEvidence::Count(const SlidingWindow& window, const WindowLandmark& landmark, int plane) {
  std::vector<Spot>& table = spots_[window.planes[plane].id];
  if (table.empty()) table.resize(kNumSets * kSpotsPerSet);
  const std::uint64_t key = SpotOf(window, landmark, plane);
  Spot* const set = &table[key % kNumSets * kSpotsPerSet];
  Spot* const end = set + kSpotsPerSet;
  Spot* spot = std::find_if(set, end, [&](const Spot& s) { return s.tag == TagOf(key); });
  if (spot == end) {
    spot = std::min_element(
        set, end, [](const Spot& a, const Spot& b) { return a.num_used_up < b.num_used_up; });
    *spot = {TagOf(key), 0};
  }
  ++spot->num_used_up;
}

void PlaneEvidence::UseUp(const MarginalizationPlan& plan, const SlidingWindow& window) {
  std::erase_if(spots_, [&](const auto& entry) { return window.IndexOf(entry.first) < 0; });
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    const WindowLandmark& landmark = window.landmarks()[l];
    if (plan.drop_landmark[l] == 0 || !landmark.IsOnPlanes()) continue;
    for (const int plane : landmark.planes)
      Count(window, landmark, plane);
  }
}

}  // namespace facet
