// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/place_index.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace facet {

namespace {

constexpr int kBits = 16;
// The middle one: corners of images from nearer and farther away match it on one of their levels.
constexpr std::size_t kIndexedLevel = 1;
// Places that are nearer than this in time see the same.
constexpr double kNeighbours_s = 2.5;

/// The pieces of all tables are apart from each other.
std::uint32_t Piece(const BinaryDescriptor& descriptor, std::size_t table) {
  const std::uint64_t word = descriptor[table / 2];
  return static_cast<std::uint32_t>(table % 2 == 0 ? word >> 8 : word >> 40) & 0xFFFFU;
}

}  // namespace

PlaceIndex::PlaceIndex(const std::deque<PlaceRecord>& places, std::size_t num) {
  num = std::min({num, places.size(), kMostPlaces});
  for (std::size_t i = 0; i < num; ++i) {
    places_.push_back({places[i].t, places[i].session, static_cast<int>(places[i].points.size())});
    for (const RecordPoint& point : places[i].points) {
      for (std::size_t table = 0; table < kNumTables; ++table)
        tables_[table].push_back(Piece(point.descriptors[kIndexedLevel], table) << kBits |
                                 static_cast<std::uint32_t>(i));
    }
  }
  for (auto& table : tables_)
    std::sort(table.begin(), table.end());
}

std::size_t PlaceIndex::memory_bytes() const {
  std::size_t bytes = places_.capacity() * sizeof(When);
  for (const auto& table : tables_)
    bytes += table.capacity() * sizeof(std::uint32_t);
  return bytes;
}

std::vector<int> PlaceIndex::Best(std::span<const UprightCorner> corners, std::size_t most) const {
  // Pieces that many corners have (all bits alike, repeated texture) say nothing.
  constexpr std::size_t kLeastCommon = 40;
  const std::size_t too_common = std::max(kLeastCommon, tables_[0].size() / 500);
  std::vector<double> votes(places_.size(), 0);
  std::vector<std::size_t> last_corner(places_.size(), corners.size());
  for (std::size_t c = 0; c < corners.size(); ++c) {
    for (std::size_t table = 0; table < kNumTables; ++table) {
      const std::uint32_t first = Piece(corners[c].descriptor, table) << kBits;
      const auto begin = std::lower_bound(tables_[table].begin(), tables_[table].end(), first);
      const auto end = std::upper_bound(begin, tables_[table].end(), first | 0xFFFFU);
      if (static_cast<std::size_t>(end - begin) > too_common) continue;
      for (auto entry = begin; entry != end; ++entry) {
        const std::size_t place = *entry & 0xFFFFU;
        if (last_corner[place] == c) continue;  // one vote for each corner
        last_corner[place] = c;
        votes[place] += 1;
      }
    }
  }
  std::vector<int> order;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    // By chance a place gets as many votes as it has points.
    votes[i] /= std::sqrt(std::max(1, places_[i].num_points));
    if (votes[i] > 0) order.push_back(static_cast<int>(i));
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return votes[a] > votes[b]; });
  std::vector<int> best;
  for (const int place : order) {
    if (best.size() == most) break;
    const bool is_neighbour = std::any_of(best.begin(), best.end(), [&](int other) {
      return places_[other].session == places_[place].session &&
             std::abs(ToSeconds(places_[other].t - places_[place].t)) < kNeighbours_s;
    });
    if (!is_neighbour) best.push_back(place);
  }
  return best;
}

}  // namespace facet
