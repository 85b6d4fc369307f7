// SPDX-License-Identifier: BSD-2-Clause
// First distance of a landmark: from its stereo pair or from parallax between frames.
#pragma once

#include <array>
#include <vector>

#include "facet/estimator/window/frame_geometry.h"
#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// Sets bearing and inverse distance of a landmark that has none, if its observations determine it:
/// a stereo pair in the host, or rays from several frames whose baseline is wide enough. Least
/// squares on the epipolar plane residual (docs/math.md, equation (3.9)); points at infinity get
/// inverse distance 0. Returns has_depth.
bool InitializeDepth(const FrameGeometry& geometry, WindowLandmark& landmark);

/// The same for every landmark without a distance. `geometry` must be up to date.
void InitializeDepths(const FrameGeometry& geometry, SlidingWindow& window);

/// Centres of both cameras at one frame, in W.
using CameraCentres = std::array<Vector3d, 2>;

/// Information (inverse variance) on the inverse distance of a landmark [m^2], from its
/// observations with all poses taken as known. First order in baseline over distance: the baseline
/// across the ray over the angular noise, squared and summed. `centres` by frame of the window.
double InverseDistanceInformation(const WindowLandmark& landmark,
                                  const Vector3d& ray_W,
                                  const std::vector<CameraCentres>& centres);

}  // namespace facet
