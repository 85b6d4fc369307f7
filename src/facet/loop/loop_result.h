// SPDX-License-Identifier: BSD-2-Clause
// What the map of places knows at the end of a run.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "facet/loop/place_map.h"

namespace facet {

struct LoopResult {
  std::vector<MapCorrection> corrections;  ///< in order of time
  std::vector<ClosureRecord> closures;     ///< everything that was compared
  int num_places = 0;                      ///< with those of runs before
  int num_known_places = 0;                ///< of runs before
  bool has_known_map = false;
  std::optional<Timestamp> localised;  ///< the keyframe by which the run was found in the known map
  bool is_ambiguous = false;           ///< it looks like more than one place there
  std::shared_ptr<const SavedMap> map;  ///< if it is to be kept
  double memory_mb = 0;
  double cpu_ms = 0;  ///< of all the work on places

  int NumAccepted() const {
    int num = 0;
    for (const ClosureRecord& closure : closures)
      num += closure.verdict == kClosureAccepted ? 1 : 0;
    return num;
  }
};

}  // namespace facet
