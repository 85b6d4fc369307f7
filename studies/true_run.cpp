// SPDX-License-Identifier: BSD-2-Clause
#include "true_run.h"

#include <filesystem>
#include <span>

#include "facet/eval/trajectory_error.h"
#include "facet/io/calibration_file.h"
#include "facet/io/errors.h"

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
      truth(ReadTrajectory(RequireTruth(folder))),
      scene(folder) {}

SE3 TrueSequence::PoseAt(Timestamp t) const {
  const StampedPose wanted{t, SE3()};
  const Association found = Associate(std::span(&wanted, 1), truth.poses);
  if (found.pairs.empty()) throw InputError("the ground truth does not cover the images");
  return found.pairs.front().T_GB;
}

void RunStages(TrueSequence& sequence,
               const VioOptions& options,
               const VisitFrame& visit,
               const std::function<void(const VioOutput&)>& take_output) {
  const auto visit_tracked = [&](std::size_t, const StereoFrame& frame, TrackedFrame& tracked) {
    visit(sequence.PoseAt(frame.t), tracked.frontend.observations);
    return true;
  };
  RunStages(sequence.dataset, options, visit_tracked, take_output);
}

}  // namespace facet
