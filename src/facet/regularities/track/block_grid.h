// SPDX-License-Identifier: BSD-2-Clause
// Blocks of cells around the origin of a plane: looked up many thousand times per keyframe, so they
// lie side by side in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace facet {

/// One number per block, 0 where there is none. Memory is that of the rectangle around what was
/// set, with some room, up to kMaxBlocks.
class BlockGrid {
 public:
  static constexpr std::int64_t kMaxBlocks = std::int64_t{1} << 22;

  std::uint32_t Get(int x, int y) const { return IsInside(x, y) ? blocks_[PlaceOf(x, y)] : 0; }

  /// The number, to be changed; valid until the next call. Null if the rectangle would be too
  /// large.
  std::uint32_t* At(int x, int y);

  /// Whether predicate(x, y, number) holds for one that is not 0; they come row by row.
  template <class Predicate>
  bool AnyOf(const Predicate& predicate) const {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (blocks_[i] == 0) continue;
      const auto place = static_cast<std::int64_t>(i);
      const int x = static_cast<int>(x_ + place % width_);
      const int y = static_cast<int>(y_ + place / width_);
      if (predicate(x, y, blocks_[i])) return true;
    }
    return false;
  }

  /// Calls function(x, y, number) for each that is not 0.
  template <class Function>
  void ForEach(const Function& function) const {
    AnyOf([&](int x, int y, std::uint32_t number) {
      function(x, y, number);
      return false;
    });
  }

 private:
  bool IsInside(std::int64_t x, std::int64_t y) const {
    return x >= x_ && x < x_ + width_ && y >= y_ && y < y_ + height_;
  }
  std::size_t PlaceOf(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>((y - y_) * width_ + (x - x_));
  }
  bool Grow(int x, int y);

  std::int64_t x_ = 0, y_ = 0, width_ = 0, height_ = 0;  // the first block, and how many
  std::vector<std::uint32_t> blocks_;
};

}  // namespace facet
