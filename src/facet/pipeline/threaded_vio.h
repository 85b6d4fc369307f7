// SPDX-License-Identifier: BSD-2-Clause
// The same stages as VioPipeline on two threads: while the back half of one frame is worked on, the
// caller's thread tracks features in the next. Same results, bit for bit; only the latency differs.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "facet/pipeline/vio_pipeline.h"

namespace facet {

/// Call from one thread. Outputs come one call late.
class ThreadedVio {
 public:
  /// `on_pose` is called by the other thread as soon as a pose is known, before mesh, planes and
  /// map are worked on.
  ThreadedVio(const StereoRig& rig,
              const ImuNoise& noise,
              const VioOptions& options,
              PoseObserver on_pose = nullptr);
  ~ThreadedVio();
  ThreadedVio(const ThreadedVio&) = delete;
  ThreadedVio& operator=(const ThreadedVio&) = delete;

  void AddImu(const ImuSample& sample);

  /// Returns the outputs that became ready, oldest first; usually the one of the previous frame.
  std::vector<VioOutput> AddStereo(const StereoFrame& frame);

  /// Waits for the frames under way and returns their outputs. More frames may follow.
  std::vector<VioOutput> Finish();

  /// The output of the next keyframe tells how map and planes have changed since the last request.
  /// Changes nothing else. May be called from any thread.
  void RequestSceneUpdate();

  /// Window, map and planes; after Finish.
  RunResult Result() const;

  /// The same at the end of a run, without a copy of the map: no more frames may follow.
  RunResult TakeResult();

 private:
  class Worker;

  /// Waits for all frames but the newest `num_left`.
  std::vector<VioOutput> TakeDone(std::int64_t num_left);

  std::unique_ptr<VioStages> stages_;
  PoseObserver on_pose_;
  std::unique_ptr<Worker> worker_;  // last: it uses the others
};

}  // namespace facet
