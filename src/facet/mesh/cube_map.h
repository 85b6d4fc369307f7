// SPDX-License-Identifier: BSD-2-Clause
// Numbers of cubes in a grid. A map of the standard library takes three times as long to find one,
// and the surface map asks all the time.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace facet {

/// Place in a grid of cubes.
struct CubeIndex {
  std::int32_t x = 0, y = 0, z = 0;
  auto operator<=>(const CubeIndex&) const = default;
};

/// A hash table that gives each cube a number, from 0 on. Cubes can be added but not removed (open
/// addressing with linear probing).
class CubeMap {
 public:
  static constexpr int kNone = -1;

  /// kNone for a cube that was not added.
  int Find(const CubeIndex& cube) const { return slots_[SlotOf(cube)].number; }

  /// The cube must be new and the number not negative.
  void Add(const CubeIndex& cube, int number) {
    if (2 * ++count_ > slots_.size()) Grow();
    slots_[SlotOf(cube)] = {cube, number};
  }

 private:
  struct Slot {
    CubeIndex cube;
    int number = kNone;
  };

  static std::size_t HashOf(const CubeIndex& c) {
    std::uint64_t h = static_cast<std::uint32_t>(c.x) * 0x9E3779B97F4A7C15ULL;
    h = (h ^ static_cast<std::uint32_t>(c.y)) * 0xBF58476D1CE4E5B9ULL;
    h = (h ^ (h >> 29) ^ static_cast<std::uint32_t>(c.z)) * 0x94D049BB133111EBULL;
    return h ^ (h >> 32);
  }

  /// The cube's slot, or the empty one where it would be.
  std::size_t SlotOf(const CubeIndex& cube) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = HashOf(cube) & mask;
    while (slots_[slot].number != kNone && slots_[slot].cube != cube)
      slot = (slot + 1) & mask;
    return slot;
  }

  void Grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old) {
      if (slot.number != kNone) slots_[SlotOf(slot.cube)] = slot;
    }
  }

  std::vector<Slot> slots_ = std::vector<Slot>(64);  // a power of two, at most half full
  std::size_t count_ = 0;
};

}  // namespace facet
