// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace facet {

/// The triangles around each point. Keeps its buffers from call to call.
class TriangleStars {
 public:
  /// `corners_of(i)` gives the three corners of triangle i as indices below `num_points`.
  template <class CornersOf>
  void Build(std::size_t num_points, std::size_t num_triangles, const CornersOf& corners_of) {
    first_.assign(num_points + 1, 0);
    for (std::size_t i = 0; i < num_triangles; ++i) {
      for (const int corner : corners_of(i))
        ++first_[static_cast<std::size_t>(corner) + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    next_.assign(first_.begin(), first_.end() - 1);
    triangles_.resize(3 * num_triangles);
    for (std::size_t i = 0; i < num_triangles; ++i) {
      for (const int corner : corners_of(i))
        triangles_[next_[static_cast<std::size_t>(corner)]++] = static_cast<int>(i);
    }
  }

  /// Returns the triangles around a point in ascending order; valid until the next Build().
  std::span<const int> Around(int point) const {
    const auto i = static_cast<std::size_t>(point);
    return std::span(triangles_).subspan(first_[i], first_[i + 1] - first_[i]);
  }

 private:
  std::vector<std::size_t> first_;  // by point: where its triangles begin
  std::vector<std::size_t> next_;
  std::vector<int> triangles_;
};

}  // namespace facet
