// SPDX-License-Identifier: BSD-2-Clause
// The odometry in a running system: IMU, images and a controller each have a thread of their own,
// and none of them waits for the estimator.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "facet/camera/stereo_rig.h"
#include "facet/frontend/stereo_frontend.h"
#include "facet/imu/imu_types.h"
#include "facet/live/predicted_state.h"
#include "facet/live/state_predictor.h"
#include "facet/pipeline/run_result.h"
#include "facet/pipeline/vio_options.h"
#include "facet/pipeline/vio_output.h"

namespace facet {

struct LiveOptions {
  PredictionOptions prediction;
  /// Stereo pairs that wait for the estimator; one more, and the oldest of them is dropped. A
  /// longer queue drops less and makes poses older.
  std::size_t max_waiting_frames = 2;
  /// Samples that wait for the frame that needs them; beyond it the oldest are dropped. Two minutes
  /// at 200 Hz before the first frame.
  std::size_t max_waiting_imu = 24'000;
  /// A frame waits this long, by the clock of the machine, for the sample that follows its stamp.
  /// Then it is worked on with what there is.
  double max_imu_wait_s = 0.1;
  /// Tracking of a frame beside the mesh of the one before, on a second thread.
  bool two_threads = false;
};

/// What has become of what came in.
struct LiveCounts {
  std::int64_t frames = 0;           ///< given to AddStereo
  std::int64_t done_frames = 0;      ///< whose pose is known, or known to be unknown
  std::int64_t dropped_frames = 0;   ///< that came while the queue was full, or after the end
  std::int64_t imu = 0;              ///< given to AddImu
  std::int64_t dropped_imu = 0;      ///< that the estimator will never see
  std::int64_t late_imu_frames = 0;  ///< worked on without a sample that follows their stamp
  /// From AddStereo to the moment when PredictAt knows of the frame [s]: of the newest frame, and
  /// the largest so far.
  double latency_s = 0, max_latency_s = 0;
  /// The estimator has thrown, or a callback has: what comes is dropped, and Finish throws it.
  bool has_failed = false;
};

/// Thread-safe. Images may come from one thread and IMU samples from another; each of them in order
/// of time. With the samples up to a frame and one more before max_imu_wait_s is over, and with
/// nothing dropped, the outputs are those of VioPipeline, byte for byte.
class LiveVio {
 public:
  /// `on_pose` and `on_output` are called on threads of this object, for each frame in order: as
  /// soon as its pose is known, and with its mesh when everything is. They may be empty, and must
  /// not wait for this object, nor throw, which ends it.
  LiveVio(const StereoRig& rig,
          const ImuNoise& noise,
          const VioOptions& options,
          const LiveOptions& live = {},
          PoseObserver on_pose = nullptr,
          std::function<void(const VioOutput&)> on_output = nullptr);
  /// Drops what waits.
  ~LiveVio();
  LiveVio(const LiveVio&) = delete;
  LiveVio& operator=(const LiveVio&) = delete;

  /// By the IMU's clock. Returns at once.
  void AddImu(const ImuSample& sample);

  /// By the camera's clock. Returns at once. The pixels are not copied: nobody may write to them
  /// any more.
  void AddStereo(const StereoFrame& frame);

  /// The state at t by the IMU's clock; see StatePredictor. Never waits for the estimator.
  std::optional<PredictedState> PredictAt(Timestamp t) const;

  /// As VioPipeline::RequestSceneUpdate.
  void RequestSceneUpdate();

  LiveCounts counts() const;

  /// Waits until every frame that has come is done or dropped, and ends: what comes later is
  /// dropped. Throws what the estimator or a callback threw, which ends it, too. From one thread.
  RunResult Finish();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace facet
