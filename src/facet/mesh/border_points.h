// SPDX-License-Identifier: BSD-2-Clause
// Corners and matches end some way before the border of the image, and their triangles with them.
// Where the points nearest to a place on the border lie on one plane, the plane is continued to it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "facet/mesh/mesh_options.h"
#include "facet/mesh/mesh_view.h"

namespace facet {

/// Not thread-safe; keeps its buffers.
class BorderPoints {
 public:
  explicit BorderPoints(const BorderOptions& options) : options_(options) {}

  /// Depth at a place of the view (on the plane z = 1), continued from the points nearest to it;
  /// the point has no id. Empty where these are too few, too far away or on no
  /// plane, or where the plane is known too badly that far out.
  std::optional<MeshPoint> Continue(const MeshView& view, const Vector2d& xy);

 private:
  struct Neighbour {
    double distance2 = 0;
    int point = 0;  // of the view
  };
  bool FindNearest(const MeshView& view, const Vector2d& xy);

  BorderOptions options_;
  std::vector<Neighbour> nearest_;
};

}  // namespace facet
