// SPDX-License-Identifier: BSD-2-Clause
// Made-up views of a calibration board, as somebody shows one to two cameras.
#pragma once

#include <array>
#include <vector>

#include "facet/base/random.h"
#include "facet/camera/stereo_rig.h"

namespace facet {

/// Kalibr's AprilGrid. Its corners lie in the plane z = 0 of the board, around its middle.
struct BoardOptions {
  int rows = 6, columns = 6;         ///< of tags
  double tag_m = 0.088;              ///< edge of a tag
  double gap = 0.3;                  ///< between tags, in edges of a tag
  int num_views = 40;                ///< stereo pairs
  double near_m = 0.6, far_m = 1.3;  ///< depth of the board's middle
  double turn_rad = 0.5;             ///< 1-sigma about each axis, from facing the cameras
};

struct BoardView {
  SE3 T_C0_board;
  /// Corners of the tags that a camera has completely in view, in the board's frame [m].
  std::array<std::vector<Vector3d>, 2> corners;
};

/// Views in which both cameras have enough tags in view. The middle of the board is anywhere in the
/// left image but near its border. Empty if the cameras do not see the same things at such depths.
std::vector<BoardView> MakeUpBoardViews(const StereoRig& rig,
                                        const BoardOptions& options,
                                        Rng& rng);

}  // namespace facet
