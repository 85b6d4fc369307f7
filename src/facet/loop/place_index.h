// SPDX-License-Identifier: BSD-2-Clause
// Which places of a map look like an image, with nothing known of where it was taken. Pieces of the
// binary descriptors are looked up exactly (locality-sensitive hashing by bit sampling; Indyk and
// Motwani, STOC 1998): descriptors of the same corner share some of their pieces, others hardly
// any.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "facet/loop/place_record.h"

namespace facet {

/// Deterministic. 32 to 64 bytes for each point of the map.
class PlaceIndex {
 public:
  /// Of the first `num` places, at most 65536; later ones are left out.
  explicit PlaceIndex(const std::deque<PlaceRecord>& places, std::size_t num = kMostPlaces);

  /// At most `most` places, the likeliest first; of neighbours in time only the best one.
  std::vector<int> Best(std::span<const UprightCorner> corners, std::size_t most) const;

  std::size_t memory_bytes() const;

 private:
  static constexpr std::size_t kMostPlaces = 65536;
  static constexpr std::size_t kNumTables = 8;

  struct When {
    Timestamp t;
    int session = 0;
    int num_points = 0;
  };

  std::vector<When> places_;
  // By table, in order: a piece of 16 bits above the number of the place.
  std::array<std::vector<std::uint32_t>, kNumTables> tables_;
};

}  // namespace facet
