// SPDX-License-Identifier: BSD-2-Clause
// A map of places as it is kept from one run to the next. io/saved_map_file.h has it as a file.
#pragma once

#include <vector>

#include "facet/camera/camera_intrinsics.h"
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
  std::vector<CameraIntrinsics> lenses;  ///< of the left camera, by session
  GraphState graph;
  std::vector<MapKeyframe> keyframes;  ///< like the graph's nodes
  std::vector<PlaceRecord> places;

  int num_sessions() const { return static_cast<int>(lenses.size()); }
};

}  // namespace facet
