// SPDX-License-Identifier: BSD-2-Clause
// A map of places as it is kept from one run to the next. io/saved_map_file.h has it as a file.
#pragma once

#include <vector>

#include "facet/loop/map_graph.h"
#include "facet/loop/place_record.h"

namespace facet {

/// A keyframe that is a node of the graph.
struct MapKeyframe {
  FrameId frame;  ///< of its session
  Timestamp t;
  int segment = 0;
  int session = 0;
};

struct SavedMap {
  int num_sessions = 0;
  GraphState graph;
  std::vector<MapKeyframe> keyframes;  ///< like the graph's nodes
  std::vector<PlaceRecord> places;
};

}  // namespace facet
