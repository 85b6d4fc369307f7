// SPDX-License-Identifier: BSD-2-Clause
// What the window knows, as plain data for the mesher, the search for planes and the outputs.
#pragma once

#include <span>
#include <utility>

#include "facet/camera/stereo_rig.h"
#include "facet/estimator/window/sliding_window.h"
#include "facet/map/map_snapshot.h"

namespace facet {

/// PlaneEstimate::covariance of one plane.
using PlaneCovariance = std::pair<PlaneId, Matrix<10, 10>>;

/// The newest frame, reported keyframes, planes, relations and the landmarks with a distance,
/// sorted by id. Planes without an entry in `covariances` have covariance zero. At least one frame.
MapSnapshot SnapshotWindow(const SlidingWindow& window,
                           const StereoRig& rig,
                           std::span<const PlaneCovariance> covariances);

}  // namespace facet
