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

/// When a plane may be continued to a place on the border.
struct BorderLimits {
  /// Nearest points that must lie on one plane. With eight, two surfaces rarely look like one.
  int num_neighbours = 8;
  /// No point of the border where another point is nearer, or where fewer than the neighbours are
  /// within reach; angles, in pixels of the focal length.
  double min_distance_px = 25, max_distance_px = 250;
  double max_sigmas = 2;          ///< deviation of each neighbour from the plane
  double max_depth_sigma = 0.03;  ///< 1-sigma of the continued distance over itself
};

/// Not thread-safe; keeps its buffers.
class BorderPoints {
 public:
  explicit BorderPoints(const BorderLimits& limits = {}) : limits_(limits) {}

  /// Distance at a place of the view (unit vector of its camera), continued from the points nearest
  /// to it; the point has no id. Empty where these are too few, too far away or on no plane, or
  /// where the plane is known too badly that far out.
  std::optional<MeshPoint> Continue(const MeshView& view, const Vector3d& place);

 private:
  struct Neighbour {
    double distance2 = 0;
    int point = 0;  // of the view
  };
  bool FindNearest(const MeshView& view, const Vector3d& place);

  BorderLimits limits_;
  std::vector<Neighbour> nearest_;
};

}  // namespace facet
