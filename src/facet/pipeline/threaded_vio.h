// SPDX-License-Identifier: BSD-2-Clause
// The same stages as VioPipeline on two threads: while the back stage works on one frame, the
// caller's thread tracks features in the next. Same results, bit for bit; only the latency differs.
// The only file with threads in the library.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "facet/map/plane_record.h"
#include "facet/pipeline/vio_pipeline.h"

namespace facet {

/// Call from one thread. Outputs come one call late.
class ThreadedVio {
 public:
  ThreadedVio(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options);
  ~ThreadedVio();
  ThreadedVio(const ThreadedVio&) = delete;
  ThreadedVio& operator=(const ThreadedVio&) = delete;

  void AddImu(const ImuSample& sample);

  /// Returns the outputs that became ready, oldest first; usually the one of the previous frame.
  std::vector<VioOutput> AddStereo(const StereoFrame& frame);

  /// Waits for the frames under way and returns their outputs. More frames may follow.
  std::vector<VioOutput> Finish();

  /// The keyframes that are still in the window, oldest first; after Finish.
  std::vector<KeyframePose> WindowKeyframes() const;

  /// The mesh of the whole run so far; empty when the map is switched off. After Finish.
  std::optional<TriangleMesh> Map() const;
  /// What that takes up. After Finish.
  MapMemory map_memory() const;

  /// Every plane that was ever a variable, in the order of their ids; none in pipeline S.
  std::vector<PlaneRecord> Planes() const;

  int num_refused_imu() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace facet
