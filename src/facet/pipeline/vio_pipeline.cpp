// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/vio_pipeline.h"

#include <utility>

#include "facet/pipeline/process_frame.h"
#include "facet/pipeline/vio_stages.h"

namespace facet {

VioPipeline::VioPipeline(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options)
    : stages_(std::make_unique<VioStages>(rig, noise, options)) {}

VioPipeline::~VioPipeline() = default;

void VioPipeline::AddImu(const ImuSample& sample) {
  stages_->front.AddImu(sample);
}

VioOutput VioPipeline::AddStereo(const StereoFrame& frame, const PoseObserver& on_pose) {
  auto& [front, pose, scene, loops] = *stages_;
  const BackHalf back_half = ProcessFrame(front, pose, scene, loops, frame, on_pose);
  ProcessedFrame processed = back_half();
  if (processed.feedback) front.AddFeedback(std::move(*processed.feedback));
  return std::move(processed.output);
}

void VioPipeline::RequestSceneUpdate() {
  stages_->scene.RequestUpdate();
}

RunResult VioPipeline::Result() const {
  return stages_->Result();
}

RunResult VioPipeline::TakeResult() {
  return stages_->TakeResult();
}

}  // namespace facet
