// SPDX-License-Identifier: BSD-2-Clause
#include "stage_run.h"

#include <utility>

#include "facet/io/config_file.h"
#include "facet/io/errors.h"
#include "facet/pipeline/process_frame.h"

namespace facet {

VioOptions OptionsOfS(const std::vector<std::string>& overrides) {
  VioOptions options;
  options.pipeline = Formulation::kS;
  options.mesh.enabled = false;
  ApplyOverrides(overrides, ListFields(options));
  return options;
}

namespace {

// The front stage, with somebody looking at what it hands over.
class VisitedFront {
 public:
  VisitedFront(FrontStage& front, const VisitTracked& visit) : front_(front), visit_(visit) {}

  MotionPrediction Predict(Timestamp t) { return front_.Predict(t); }
  TrackedFrame Track(const StereoFrame& frame, MotionPrediction prediction) {
    TrackedFrame tracked = front_.Track(frame, std::move(prediction));
    goes_on_ = visit_(next_frame_++, frame, tracked);
    return tracked;
  }
  bool goes_on() const { return goes_on_; }

 private:
  FrontStage& front_;
  const VisitTracked& visit_;
  std::size_t next_frame_ = 0;
  bool goes_on_ = true;
};

}  // namespace

void RunStages(AslDataset& dataset,
               const StereoRig& rig,
               const VioOptions& options,
               const VisitTracked& visit,
               const std::function<void(const VioOutput&)>& take_output) {
  FrontStage front(rig, options);
  PoseStage pose(rig, dataset.imu_noise(), options);
  SceneStage scene(rig, options);
  LoopStage loops(rig, options);
  VisitedFront visited(front, visit);
  std::size_t next_imu = 0;
  for (std::size_t i = 0; i < dataset.frames().size(); ++i) {
    const Timestamp t = dataset.frames()[i].t;
    const auto& imu = dataset.imu();
    while (next_imu < imu.size() && (next_imu == 0 || imu[next_imu - 1].t <= t))
      front.AddImu(imu[next_imu++]);
    StereoFrame frame{t, {}, {}};
    dataset.ReadPair(i, frame.left, frame.right);
    const BackHalf back_half = ProcessFrame(visited, pose, scene, loops, frame, nullptr);
    if (!visited.goes_on()) return;
    ProcessedFrame processed = back_half();
    if (processed.feedback) front.AddFeedback(std::move(*processed.feedback));
    take_output(processed.output);
  }
}

void RunStages(AslDataset& dataset,
               const VioOptions& options,
               const VisitTracked& visit,
               const std::function<void(const VioOutput&)>& take_output) {
  RunStages(dataset, dataset.rig(), options, visit, take_output);
}

}  // namespace facet
