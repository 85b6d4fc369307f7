// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/vio_pipeline.h"

#include "facet/pipeline/back_stage.h"
#include "facet/pipeline/front_stage.h"

namespace facet {

struct VioPipeline::Impl {
  Impl(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options)
      : front(rig, options), back(rig, noise, options) {}
  FrontStage front;
  BackStage back;
  int num_refused_imu = 0;
};

VioPipeline::VioPipeline(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options)
    : impl_(std::make_unique<Impl>(rig, noise, options)) {}

VioPipeline::~VioPipeline() = default;

void VioPipeline::AddImu(const ImuSample& sample) {
  if (impl_->front.AddImu(sample) != ImuBuffer::AddResult::kAdded) ++impl_->num_refused_imu;
}

VioOutput VioPipeline::AddStereo(const StereoFrame& frame) {
  const FrontPacket packet = impl_->front.Process(frame);
  VioOutput output = impl_->back.Process(packet);
  if (impl_->back.feedback()) impl_->front.AddFeedback(*impl_->back.feedback());
  return output;
}

std::vector<KeyframePose> VioPipeline::WindowKeyframes() const {
  return impl_->back.WindowKeyframes();
}

std::optional<TriangleMesh> VioPipeline::Map() const {
  return impl_->back.Map();
}

MapMemory VioPipeline::map_memory() const {
  return impl_->back.map_memory();
}

std::vector<PlaneRecord> VioPipeline::Planes() const {
  return impl_->back.Planes();
}

int VioPipeline::num_refused_imu() const {
  return impl_->num_refused_imu;
}

}  // namespace facet
