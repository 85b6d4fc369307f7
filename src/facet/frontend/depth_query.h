// SPDX-License-Identifier: BSD-2-Clause
// Distance of a place in the left image that is not tracked: question and answer.
#pragma once

#include <array>
#include <cstdint>

#include "facet/base/types.h"

namespace facet {

struct DepthQuery {
  Vector2d px = Vector2d::Zero();  ///< in the newest left image
  /// Where to look along the epipolar line [1/m], best guess first; each is the centre of a search
  /// over some pixels.
  std::array<double, 3> inverse_distances{};
  int num_depths = 0;
};

/// A point that was matched left to right in one keyframe and is not tracked: it makes the mesh
/// denser between the tracked corners. The estimator does not know it.
struct SupportPoint {
  Vector2d px = Vector2d::Zero();
  Vector2d px_right = Vector2d::Zero();
  Vector3d bearing = Vector3d::UnitZ();  ///< unit vector of the left camera
  double inverse_distance = 0;           ///< [1/m] from the left camera, above 0
  double sigma_inverse_distance = 0;     ///< 1-sigma
  std::uint8_t intensity = 0;            ///< of the left image there
};

}  // namespace facet
