// SPDX-License-Identifier: BSD-2-Clause
// A picture that can be tracked: for tests that need images but no scene.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace facet::testing {

/// A wall of random squares, their borders as soft as a lens makes them: 8-bit grey, row by row.
/// The right camera of a pair sees it from another `first_column`, the disparity.
inline std::vector<std::uint8_t> WallImage(int width, int height, int first_column) {
  constexpr int kSquare = 12, kSoft = 4;
  const int num_columns = width / kSquare + 4;
  std::vector<double> squares(static_cast<std::size_t>(num_columns * (height / kSquare + 2)));
  std::mt19937 random(1);
  for (double& square : squares)
    square = static_cast<double>(random() % 256);
  const auto at = [&](int column, int row) {
    return squares[static_cast<std::size_t>(row * num_columns + column)];
  };
  const auto share_of_next = [](int place) {
    return std::max(0, place % kSquare - (kSquare - kSoft)) / static_cast<double>(kSoft);
  };
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < height; ++y) {
    for (int x = first_column; x < first_column + width; ++x) {
      const int column = x / kSquare, row = y / kSquare;
      const double u = share_of_next(x), v = share_of_next(y);
      pixels.push_back(static_cast<std::uint8_t>(
          (1 - v) * ((1 - u) * at(column, row) + u * at(column + 1, row)) +
          v * ((1 - u) * at(column, row + 1) + u * at(column + 1, row + 1))));
    }
  }
  return pixels;
}

}  // namespace facet::testing
