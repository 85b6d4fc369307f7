// SPDX-License-Identifier: BSD-2-Clause
// Every option of the map of places. `facet config` prints those that users turn.
#pragma once

#include "facet/base/options.h"

namespace facet {

struct LoopOptions {
  bool enabled = false;
  /// Least time between two keyframes that are looked for in the map [s].
  double query_interval_s = 0.5;
  /// A keyframe is not compared with places that are younger than this: the estimator still sees
  /// what they saw [s].
  double min_age_s = 8;
  /// Least number of corners that a place and a keyframe have in common.
  int min_inliers = 25;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled",
            enabled,
            Range{},
            "recognise places; corrects trajectory_map.tum, never the odometry");
    v.Field("query_interval_s",
            query_interval_s,
            Range{0.01, 60},
            "least time between keyframes that are looked for in the map [s]");
    v.Field("min_age_s", min_age_s, Range{1, 1e4}, "younger places are not recognised [s]");
    v.Field("min_inliers",
            min_inliers,
            Range{12, 400},
            "least number of corners that a place and a keyframe have in common");
  }
};

}  // namespace facet
