// SPDX-License-Identifier: BSD-2-Clause
#include "load_options.h"

#include <algorithm>

#include <spdlog/fmt/fmt.h>

#include "facet/io/config_file.h"
#include "facet/io/errors.h"

namespace facet {

VioOptions LoadOptions(const std::string& file, const std::vector<std::string>& overrides) {
  VioOptions options;
  const std::vector<ConfigField> fields = ListFields(options);
  if (!file.empty()) ApplyConfig(ReadConfigFile(file), fields);
  ApplyOverrides(overrides, fields);
  if (options.pipeline != "S" && options.pipeline != "SP" && options.pipeline != "SPR") {
    throw ConfigError("pipeline: '" + options.pipeline + "' is unknown; S, SP and SPR are known");
  }
  // Else only corners of the grid that happen to be near a surface would know it.
  const SurfaceMapOptions& map = options.mesh.map;
  if (map.enabled && map.truncation_m < map.voxel_m) {
    throw ConfigError(
        fmt::format("mesh.map.truncation_m = {} is below mesh.map.voxel_m = {}: the map "
                    "would have holes everywhere; twice the voxel is usual",
                    map.truncation_m,
                    map.voxel_m));
  }
  const PlaneTrackingOptions& tracking = options.regularities.tracking;
  if (tracking.max_gate_m < tracking.min_gate_m) {
    throw ConfigError(
        fmt::format("regularities.tracking.max_gate_m = {} is below "
                    "regularities.tracking.min_gate_m = {}",
                    tracking.max_gate_m,
                    tracking.min_gate_m));
  }
  // Else planes would be handed over and dropped again, keyframe after keyframe.
  const bool may_be_few = tracking.max_spread_sigma_deg > 0;
  const int least = may_be_few ? std::min(tracking.min_landmarks, tracking.min_spread_landmarks)
                               : tracking.min_landmarks;
  if (options.estimator.planes.min_landmarks > least) {
    throw ConfigError(
        fmt::format("estimator.planes.min_landmarks = {} is above {}, the least that "
                    "regularities.tracking (min_landmarks, min_spread_landmarks) asks of a new "
                    "plane: planes would be found and dropped again",
                    options.estimator.planes.min_landmarks,
                    least));
  }
  return options;
}

std::string FormatOptions(VioOptions options) {
  return "# Facet's parameters: value, meaning, [what is allowed]. `facet config` prints the "
         "defaults.\n" +
         FormatConfig(ListFields(options));
}

}  // namespace facet
