// SPDX-License-Identifier: BSD-2-Clause
#include "stage_run.h"

#include "facet/io/config_file.h"
#include "facet/io/errors.h"
#include "facet/pipeline/back_stage.h"

namespace facet {

VioOptions OptionsOfS(const std::vector<std::string>& overrides) {
  VioOptions options;
  options.pipeline = "S";
  options.mesh.enabled = false;
  ApplyOverrides(overrides, ListFields(options));
  const std::string problem = Contradiction(options);
  if (!problem.empty()) throw ConfigError(problem);
  return options;
}

void RunStages(AslDataset& dataset,
               const StereoRig& rig,
               const VioOptions& options,
               const VisitPacket& visit,
               const std::function<void(const VioOutput&)>& take_output) {
  FrontStage front(rig, options);
  BackStage back(rig, dataset.imu_noise(), options);
  std::size_t next_imu = 0;
  for (std::size_t i = 0; i < dataset.frames().size(); ++i) {
    const Timestamp t = dataset.frames()[i].t;
    const auto& imu = dataset.imu();
    while (next_imu < imu.size() && (next_imu == 0 || imu[next_imu - 1].t <= t))
      front.AddImu(imu[next_imu++]);
    StereoFrame frame{t, {}, {}};
    dataset.ReadPair(i, frame.left, frame.right);
    FrontPacket packet = front.Process(frame);
    if (!visit(i, frame, packet)) return;
    const VioOutput out = back.Process(packet);
    if (back.feedback()) front.AddFeedback(*back.feedback());
    take_output(out);
  }
}

void RunStages(AslDataset& dataset,
               const VioOptions& options,
               const VisitPacket& visit,
               const std::function<void(const VioOutput&)>& take_output) {
  RunStages(dataset, dataset.rig(), options, visit, take_output);
}

}  // namespace facet
