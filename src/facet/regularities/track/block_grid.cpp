// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/block_grid.h"

#include <algorithm>
#include <utility>

namespace facet {

namespace {

struct CellRange {
  std::int64_t first, size;
};

// With room for more on the side where it grows.
CellRange Including(std::int64_t first, std::int64_t size, std::int64_t x, std::int64_t room) {
  if (size == 0) return {x, 1};
  if (x < first) return {x - room, first + size - (x - room)};
  if (x >= first + size) return {first, x + room + 1 - first};
  return {first, size};
}

}  // namespace

std::uint32_t* BlockGrid::At(int x, int y) {
  if (!IsInside(x, y) && !Grow(x, y)) return nullptr;
  return &blocks_[PlaceOf(x, y)];
}

bool BlockGrid::Grow(int x, int y) {
  const auto fits = [](const CellRange& columns, const CellRange& rows) {
    return columns.size <= kMaxBlocks && rows.size <= kMaxBlocks &&
           columns.size * rows.size <= kMaxBlocks;
  };
  // Half as much again each time, so that this is rare.
  CellRange columns = Including(x_, width_, x, width_ / 2);
  CellRange rows = Including(y_, height_, y, height_ / 2);
  if (!fits(columns, rows)) {
    columns = Including(x_, width_, x, 0);
    rows = Including(y_, height_, y, 0);
    if (!fits(columns, rows)) return false;
  }
  std::vector<std::uint32_t> grown(static_cast<std::size_t>(columns.size * rows.size), 0);
  for (std::int64_t row = 0; row < height_; ++row) {
    std::copy_n(blocks_.begin() + row * width_,
                width_,
                grown.begin() + (row + y_ - rows.first) * columns.size + x_ - columns.first);
  }
  blocks_ = std::move(grown);
  x_ = columns.first;
  y_ = rows.first;
  width_ = columns.size;
  height_ = rows.size;
  return true;
}

}  // namespace facet
