// SPDX-License-Identifier: BSD-2-Clause
// First distance of a landmark: from its stereo pair or from parallax between frames.
#pragma once

#include "facet/estimator/vision_factor.h"

namespace facet {

/// Sets bearing and inverse distance of a landmark that has none, if its observations determine it:
/// a stereo pair in the host, or rays from several frames whose baseline is wide enough. Least
/// squares on the epipolar plane residual; points at infinity get inverse distance 0. Returns
/// has_depth.
bool InitializeDepth(const FrameGeometry& geometry, WindowLandmark& landmark);

}  // namespace facet
