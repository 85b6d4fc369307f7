// SPDX-License-Identifier: BSD-2-Clause
// From the pixels of one stereo frame to the observations of the window.
#pragma once

#include <vector>

#include "facet/calibration/lens_modes.h"
#include "facet/camera/stereo_rig.h"
#include "facet/estimator/window/sliding_window.h"
#include "facet/map/observation.h"

namespace facet {

/// One observation that is not in the window yet.
struct PreparedObservation {
  LandmarkId landmark;
  WindowObservation observation;  ///< `frame` is not set
};

/// Takes the pixels to rays and whitens them by their sigmas times `pixel_sigma_scale`. Pixels that
/// have no ray, and what has no positive sigma, are passed over. `beside_model`: what the lenses do
/// there is taken from the pixels; nothing where it is a variable of the window.
std::vector<PreparedObservation> PrepareObservations(const FrameObservations& observations,
                                                     const StereoRig& rig,
                                                     double pixel_sigma_scale,
                                                     const LensFields& beside_model = {});

/// Adds what the newest frame sees; landmarks that are not in the window come into it. Of several
/// observations of one landmark the first one counts.
void AppendObservations(const std::vector<PreparedObservation>& prepared, SlidingWindow& window);

}  // namespace facet
