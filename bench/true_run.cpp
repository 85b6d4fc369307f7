// SPDX-License-Identifier: BSD-2-Clause
#include "true_run.h"

#include <filesystem>
#include <span>

#include "facet/eval/trajectory_error.h"
#include "facet/io/calibration_file.h"
#include "facet/io/config_file.h"
#include "facet/io/errors.h"
#include "facet/pipeline/back_stage.h"
#include "facet/pipeline/front_stage.h"

namespace facet {

namespace {

// Without a calibration in truth/ the images obey the given one.
StereoRig ExactRig(const std::string& folder, const AslDataset& dataset) {
  const std::filesystem::path exact = std::filesystem::path(folder) / "truth";
  if (!std::filesystem::exists(exact / "cam0")) return dataset.rig();
  return FindCalibration({}, {exact.string(), {}}).rig;
}

}  // namespace

TrueSequence::TrueSequence(const std::string& folder)
    : dataset(folder),
      exact_rig(ExactRig(folder, dataset)),
      truth(ReadTrajectory(FindTruth(folder))),
      scene(folder) {}

SE3 TrueSequence::PoseAt(Timestamp t) const {
  const StampedPose wanted{t, SE3()};
  const Association found = Associate(std::span(&wanted, 1), truth.poses);
  if (found.pairs.empty()) throw InputError("the ground truth does not cover the images");
  return found.pairs.front().T_GB;
}

VioOptions OptionsOfS(const std::vector<std::string>& overrides) {
  VioOptions options;
  options.pipeline = "S";
  options.mesh.enabled = false;
  ApplyOverrides(overrides, ListFields(options));
  return options;
}

void RunStages(TrueSequence& sequence,
               const VioOptions& options,
               const VisitFrame& visit,
               const std::function<void(const VioOutput&)>& take_output) {
  AslDataset& dataset = sequence.dataset;
  FrontStage front(dataset.rig(), options);
  BackStage back(dataset.rig(), dataset.imu_noise(), options);
  std::size_t next_imu = 0;
  for (std::size_t i = 0; i < dataset.frames().size(); ++i) {
    const Timestamp t = dataset.frames()[i].t;
    const auto& imu = dataset.imu();
    while (next_imu < imu.size() && (next_imu == 0 || imu[next_imu - 1].t <= t))
      front.AddImu(imu[next_imu++]);
    StereoFrame frame{t, {}, {}};
    dataset.ReadPair(i, frame.left, frame.right);
    FrontPacket packet = front.Process(frame);
    visit(static_cast<int>(i), sequence.PoseAt(t), frame.left, packet.frontend.observations);
    const VioOutput out = back.Process(packet);
    if (back.feedback()) front.AddFeedback(*back.feedback());
    take_output(out);
  }
}

}  // namespace facet
