// SPDX-License-Identifier: BSD-2-Clause
// Recognises places and keeps T_MW, from the odometry's world to the map. Reads what the other
// stages have made of a frame and changes nothing of it.
#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "facet/camera/stereo_rig.h"
#include "facet/loop/loop_result.h"
#include "facet/loop/place_map.h"
#include "facet/pipeline/tracked_frame.h"
#include "facet/pipeline/vio_options.h"
#include "facet/pipeline/vio_output.h"

namespace facet {

/// Not thread-safe. Never throws for any content of the frame.
class LoopStage {
 public:
  /// What a keyframe says about the map is part of the outputs from this many frames later on,
  /// however long the work on it took.
  static constexpr std::int64_t kLag = 5;

  LoopStage(const StereoRig& rig, const VioOptions& options);

  /// Sets `T_MW` of the output. Before the pose is told.
  void Correct(VioOutput& out);

  /// Looks for keyframes in the map, and for other frames while it is not known where the run is.
  void Add(const cv::Mat& left, const TrackedFrame& frame, const VioOutput& out);

  /// Empty if places are not recognised.
  std::optional<LoopResult> Result() const;

 private:
  struct Due {
    FrameId frame;
    SE3 T_MW;
    bool is_in_map = true;
  };

  void FillView(const cv::Mat& left, const SE3& T_WB, const VioOutput& out);
  void FillPoints(const TrackedFrame& frame, const MapSnapshot& snapshot, const StereoRig& rig);
  /// What the map says after this frame goes to the outputs when it is due.
  void Hand(FrameId frame);

  StereoRig rig_;
  std::optional<PlaceMap> map_;
  KeyframeView view_;  // keeps its storage
  std::deque<Due> due_;
  SE3 T_MW_;
  bool is_in_map_ = true;
  bool keeps_map_ = false;
  std::shared_ptr<const SavedMap> known_map_;
  int num_known_places_ = 0;
  double cpu_ms_ = 0;
};

}  // namespace facet
