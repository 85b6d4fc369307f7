// SPDX-License-Identifier: BSD-2-Clause
// All factors on one landmark, side by side: its reprojections and the planes it lies on. Unlike
// the factors between frames and planes (factor.h) they have the landmark as a variable, which is
// eliminated at once, so they add up in a LandmarkBlock.
#pragma once

#include <vector>

#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/factors/landmark_block.h"
#include "facet/estimator/window/frame_geometry.h"
#include "facet/estimator/window/window_landmark.h"

namespace facet {

/// Fills `block`, reusing its storage.
void LinearizeLandmark(const FrameGeometry& geometry,
                       const std::vector<WindowPlane>& planes,
                       const WindowLandmark& landmark,
                       const FactorNoise& noise,
                       LandmarkBlock& block,
                       LensSums* lens = nullptr);

/// Robust cost of the same rows.
double LandmarkCost(const FrameGeometry& geometry,
                    const std::vector<WindowPlane>& planes,
                    const WindowLandmark& landmark,
                    const FactorNoise& noise);

}  // namespace facet
