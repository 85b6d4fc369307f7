// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/vio_options.h"

#include <algorithm>
#include <sstream>

namespace facet {

namespace {

// What a plane must have at least before the estimator gets it.
int LeastLandmarks(const PlaneTrackingOptions& tracking) {
  const bool may_be_few = tracking.max_spread_sigma_deg > 0;
  return may_be_few ? std::min(tracking.min_landmarks, tracking.min_spread_landmarks)
                    : tracking.min_landmarks;
}

}  // namespace

std::string Contradiction(const VioOptions& options) {
  std::ostringstream text;
  const SurfaceMapOptions& map = options.mesh.map;
  const PlaneTrackingOptions& tracking = options.regularities.tracking;
  const int kept_with = options.estimator.planes.min_landmarks;
  if (options.pipeline != "S" && options.pipeline != "SP" && options.pipeline != "SPR") {
    text << "pipeline: '" << options.pipeline << "' is unknown; S, SP and SPR are known";
  } else if (map.enabled && map.truncation_m < map.voxel_m) {
    // Only corners of the grid that happen to be near a surface would know it.
    text << "mesh.map.truncation_m = " << map.truncation_m
         << " is below mesh.map.voxel_m = " << map.voxel_m
         << ": the map would have holes everywhere; twice the voxel is usual";
  } else if (tracking.max_gate_m < tracking.min_gate_m) {
    text << "regularities.tracking.max_gate_m = " << tracking.max_gate_m
         << " is below regularities.tracking.min_gate_m = " << tracking.min_gate_m;
  } else if (options.pipeline == "SPR" && kept_with > LeastLandmarks(tracking)) {
    text
        << "estimator.planes.min_landmarks = " << kept_with << " is above "
        << LeastLandmarks(tracking)
        << ", the least that regularities.tracking (min_landmarks, min_spread_landmarks) asks of a "
           "new plane: planes would be found and dropped again";
  }
  return text.str();
}

}  // namespace facet
