// SPDX-License-Identifier: BSD-2-Clause
// For tests: the back half of the pipeline on simulated features, without images. `Run`:
// SimulatedRun, which product code may not know.
#pragma once

#include <algorithm>

#include "facet/pipeline/back_stage.h"

namespace facet::testing {

/// What the front stage would hand over for a frame. Without support points.
template <class Run>
FrontPacket PacketOf(const Run& run, const ImuBuffer& imu, std::size_t frame) {
  FrontPacket packet;
  FrameObservations& observations = packet.frontend.observations;
  observations = run.frames[frame];
  std::sort(observations.features.begin(), observations.features.end(), [](auto& a, auto& b) {
    return a.landmark < b.landmark;
  });
  packet.mesh.intensities.assign(observations.features.size(), 128);
  packet.mesh.inverse_depths.assign(observations.features.size(), 0);
  if (frame > 0) {
    packet.imu =
        imu.Between(run.truth[frame - 1].t, run.truth[frame].t, Duration{20'000'000}, Duration{0});
  }
  return packet;
}

/// Calls `watch` with the output of each frame.
template <class Run, class Watch>
void RunBackStage(BackStage& back, const Run& run, const Watch& watch) {
  ImuBuffer imu;
  for (const ImuSample& sample : run.imu)
    imu.Add(sample);
  for (std::size_t i = 0; i < run.frames.size(); ++i)
    watch(back.Process(PacketOf(run, imu, i)));
}

}  // namespace facet::testing
