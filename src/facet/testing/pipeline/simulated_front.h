// SPDX-License-Identifier: BSD-2-Clause
// The pipeline on simulated features, without images. `Run`: SimulatedRun, which the pipeline's
// library may not know.
#pragma once

#include <algorithm>
#include <utility>

#include "facet/pipeline/process_frame.h"

namespace facet::testing {

/// What the front stage would hand over for the frames of a run, one after the other. Without
/// support points.
template <class Run>
class SimulatedFront {
 public:
  explicit SimulatedFront(const Run& run) : run_(run) {
    for (const ImuSample& sample : run.imu)
      imu_.Add(sample);
  }

  MotionPrediction Predict(Timestamp /*t*/) {
    MotionPrediction prediction;
    if (frame_ > 0) {
      prediction.imu = imu_.Between(
          run_.truth[frame_ - 1].t, run_.truth[frame_].t, Duration{20'000'000}, Duration{0});
    }
    return prediction;
  }

  TrackedFrame Track(const StereoFrame& /*frame*/, MotionPrediction prediction) {
    TrackedFrame tracked;
    tracked.imu = std::move(prediction.imu);
    FrameObservations& observations = tracked.frontend.observations;
    observations = run_.frames[frame_++];
    std::sort(observations.features.begin(), observations.features.end(), [](auto& a, auto& b) {
      return a.landmark < b.landmark;
    });
    tracked.frontend.depths.intensities.assign(observations.features.size(), 128);
    tracked.frontend.depths.inverse_distances.assign(observations.features.size(), 0);
    return tracked;
  }

 private:
  const Run& run_;
  ImuBuffer imu_;
  std::size_t frame_ = 0;
};

/// Calls `watch` with the output of each frame.
template <class Run, class Watch>
void RunOnFeatures(const Run& run, const VioOptions& options, const Watch& watch) {
  SimulatedFront front(run);
  PoseStage pose(run.rig, ImuNoise{}, options);
  SceneStage scene(run.rig, options);
  LoopStage loops(run.rig, options);
  for (std::size_t i = 0; i < run.frames.size(); ++i)
    watch(ProcessFrame(front, pose, scene, loops, {run.frames[i].t, {}, {}}, nullptr)().output);
}

}  // namespace facet::testing
