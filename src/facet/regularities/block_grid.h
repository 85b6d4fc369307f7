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

  std::uint32_t Get(int x, int y) const {
    const std::int64_t column = std::int64_t{x} - x_, row = std::int64_t{y} - y_;
    const bool is_inside = column >= 0 && column < width_ && row >= 0 && row < height_;
    return is_inside ? blocks_[static_cast<std::size_t>(row * width_ + column)] : 0;
  }

  /// The number, to be changed; valid until the next call. Null if the rectangle would be too
  /// large.
  std::uint32_t* At(int x, int y);

  /// Calls function(x, y, number) for each that is not 0, row by row.
  template <class Function>
  void ForEach(const Function& function) const {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (blocks_[i] == 0) continue;
      const auto place = static_cast<std::int64_t>(i);
      function(
          static_cast<int>(x_ + place % width_), static_cast<int>(y_ + place / width_), blocks_[i]);
    }
  }

 private:
  bool Grow(int x, int y);

  std::int64_t x_ = 0, y_ = 0, width_ = 0, height_ = 0;  // the first block, and how many
  std::vector<std::uint32_t> blocks_;
};

}  // namespace facet
