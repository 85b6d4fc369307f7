// SPDX-License-Identifier: BSD-2-Clause
// A simulated sequence with its truth, and the pipeline's stages run over it.
#pragma once

#include <functional>
#include <string>

#include "stage_run.h"
#include "true_scene.h"

#include "facet/io/asl_dataset.h"
#include "facet/io/trajectory_file.h"
#include "facet/map/observation.h"

namespace facet {

struct TrueSequence {
  /// Throws InputError.
  explicit TrueSequence(const std::string& folder);

  /// The true pose at a stamp that is in the file, or between two that are. Throws InputError.
  SE3 PoseAt(Timestamp t) const;

  AslDataset dataset;
  StereoRig exact_rig;  ///< that the images obey
  Trajectory truth;
  TrueScene scene;
};

/// A frame between front and back stage: the true pose, and the observations, which may be changed.
using VisitFrame = std::function<void(const SE3& T_WB, FrameObservations&)>;

/// Calls `visit` and then, after the back stage, `take_output`, once for each frame. Throws
/// InputError.
void RunStages(TrueSequence& sequence,
               const VioOptions& options,
               const VisitFrame& visit,
               const std::function<void(const VioOutput&)>& take_output);

}  // namespace facet
