// SPDX-License-Identifier: BSD-2-Clause
// The visual-inertial odometry as one object: IMU samples and stereo pairs in, poses, mesh and
// planes out. What happens to a frame is in process_frame.h.
#pragma once

#include <memory>

#include "facet/camera/stereo_rig.h"
#include "facet/frontend/stereo_frontend.h"
#include "facet/imu/imu_types.h"
#include "facet/pipeline/run_result.h"
#include "facet/pipeline/vio_options.h"
#include "facet/pipeline/vio_output.h"

namespace facet {

struct VioStages;

/// Synchronous and deterministic; not thread-safe. Never throws for any content of images or
/// samples.
class VioPipeline {
 public:
  VioPipeline(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options);
  ~VioPipeline();
  VioPipeline(const VioPipeline&) = delete;
  VioPipeline& operator=(const VioPipeline&) = delete;

  /// IMU samples in order of time (IMU clock). Refuses and counts what is not finite or not in
  /// order. Of what comes before the first pair the last ten minutes are kept.
  void AddImu(const ImuSample& sample);

  /// A stereo pair, after the IMU samples up to its stamp (one sample beyond it is ideal).
  /// `on_pose` gets the same output without the mesh, which is then still to be made.
  VioOutput AddStereo(const StereoFrame& frame, const PoseObserver& on_pose = nullptr);

  /// The output of the next keyframe tells how map and planes have changed since the last request.
  /// Changes nothing else. May be called from any thread.
  void RequestSceneUpdate();

  /// Window, map and planes as they are now.
  RunResult Result() const;

  /// The same at the end of a run, without a copy of the map: no more frames may follow.
  RunResult TakeResult();

 private:
  std::unique_ptr<VioStages> stages_;
};

}  // namespace facet
