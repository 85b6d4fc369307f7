// SPDX-License-Identifier: BSD-2-Clause
// What is left of a run besides the outputs of its frames.
#pragma once

#include <optional>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/imu/imu_screen.h"
#include "facet/loop/loop_result.h"
#include "facet/map/map_snapshot.h"
#include "facet/map/plane_record.h"
#include "facet/mesh/surface_map.h"
#include "facet/mesh/triangle_mesh.h"

namespace facet {

struct RunResult {
  /// The keyframes that are still in the window, oldest first.
  std::vector<KeyframePose> window_keyframes;
  /// The mesh of the whole run so far, the horizon included; empty when the map is switched off.
  std::optional<TriangleMesh> map;
  MapMemory map_memory;  ///< what `map` takes up inside
  /// Every plane that was ever a variable, in the order of their ids; empty but in pipeline SPR.
  std::optional<std::vector<PlaneRecord>> planes;
  /// With what was learnt of it, and its covariance; empty if it is held, or nothing was learnt.
  std::optional<StereoRig> calibration;
  std::optional<LoopResult> loops;  ///< if places were looked for
  int num_refused_imu = 0;          ///< samples that were not finite or not in order
  int num_stray_imu = 0;            ///< samples whose stamps were far ahead of the ones around them
  ImuScreenCounts imu_screen;
};

}  // namespace facet
