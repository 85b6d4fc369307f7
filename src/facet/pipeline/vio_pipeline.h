// SPDX-License-Identifier: BSD-2-Clause
// The file to read first: one stereo frame from images and IMU samples to a causal pose.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/frontend/stereo_frontend.h"
#include "facet/imu/imu_types.h"
#include "facet/map/plane_record.h"
#include "facet/mesh/surface_map.h"
#include "facet/pipeline/vio_options.h"
#include "facet/pipeline/vio_output.h"

namespace facet {

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
  VioOutput AddStereo(const StereoFrame& frame);

  /// The keyframes that are still in the window, oldest first; for the end of a run.
  std::vector<KeyframePose> WindowKeyframes() const;

  /// The mesh of the whole run so far; empty when the map is switched off.
  std::optional<TriangleMesh> Map() const;
  /// What that takes up.
  MapMemory map_memory() const;

  /// Every plane that was ever a variable, in the order of their ids; none in pipeline S.
  std::vector<PlaneRecord> Planes() const;

  /// Samples that AddImu refused.
  int num_refused_imu() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace facet
