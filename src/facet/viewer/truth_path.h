// SPDX-License-Identifier: BSD-2-Clause
// The true trajectory beside an estimated one, for pictures. G is the frame of the truth, W the
// world of the estimate.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "facet/io/trajectory_file.h"

namespace facet {

struct TruthPath {
  SE3 T_GW;
  /// In W, at the stamps of frames from the first to the last one that has a pose, without those
  /// where the truth has a hole: the distance to the frame's own pose is its error.
  std::vector<StampedPose> poses_W;
};

/// The alignment is the one of `facet evaluate`, so that errors are the same; where the estimate
/// has moved too little for it, its first pose lies on the truth. Empty where fewer than three of
/// its poses have a truth. `frames`: the stamps of all frames, with a pose or without. All are
/// sorted by stamp.
std::optional<TruthPath> FindTruthPath(std::span<const StampedPose> estimate,
                                       std::span<const Timestamp> frames,
                                       std::span<const StampedPose> truth);

}  // namespace facet
