// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <optional>

#include "facet/frontend/stereo_turn.h"

namespace facet {

/// What a keyframe shows of the right camera and its image.
struct RightImageFindings {
  /// How far the right camera has been turned since it was calibrated or corrected last, if this
  /// keyframe makes that clear; it is corrected from this keyframe on.
  std::optional<StereoTurn> turn;
  /// By how much disparities contradict the depths that were known before [px]; the image was not
  /// used then. Empty: they do not.
  std::optional<double> contradiction_px;
};

}  // namespace facet
