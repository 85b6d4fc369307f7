// SPDX-License-Identifier: BSD-2-Clause
// `facet evaluate` without the command line: reads a result and a ground truth and computes every
// figure there is truth for. Throws InputError for what cannot be judged.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "facet/calibration/calibration_error.h"
#include "facet/eval/consistency.h"
#include "facet/eval/ground_truth.h"
#include "facet/eval/mesh_error.h"
#include "facet/eval/plane_error.h"
#include "facet/eval/trajectory_error.h"

namespace facet {

struct EvaluationOptions {
  TrajectoryErrorOptions trajectory;
  bool align_time = false;  ///< estimate and remove an offset between the clocks
  /// The trajectory is always judged; these only where result and truth have them.
  bool judge_mesh = true, judge_planes = true, judge_consistency = true;
  bool parts_must_exist = false;  ///< what is to be judged and is missing is an InputError
};

/// A stretch between two losses of the state, aligned for itself.
struct SegmentError {
  int segment = 0;
  TrajectoryError error;
};

struct RunEvaluation {
  std::filesystem::path result;
  AlignmentKind alignment = AlignmentKind::kSE3;
  std::optional<Duration> time_offset;  ///< added to the stamps of the result
  std::optional<double> coverage;       ///< share of the stereo frames that have a pose
  TrajectoryError causal;
  std::vector<PosePair> pairs;  ///< of the causal trajectory, for pictures
  std::optional<TrajectoryError> keyframes;
  std::vector<SegmentError> segments;  ///< if there are two or more; those that can be judged
  std::optional<MeshError> mesh, map;
  std::optional<PlaneError> planes;
  std::optional<PlaneError> close_planes;              ///< the same with kClosePlanes
  std::optional<PlaneError> close_planes_by_distance;  ///< and with kClosePlanesByDistance
  std::optional<ConsistencyError> consistency;
  std::optional<CalibrationError> calibration;  ///< of the one that was estimated
  std::vector<std::string> warnings;
};

/// A result folder of `facet run`, or a trajectory file of any system.
RunEvaluation EvaluateRun(const std::filesystem::path& result,
                          const GroundTruth& truth,
                          const EvaluationOptions& options);

/// RESULT/evaluation.json, or FILE.evaluation.json beside a trajectory file.
std::filesystem::path EvaluationFile(const std::filesystem::path& result);

/// Writes the file as a whole or not at all; throws OutputError.
void WriteEvaluation(const RunEvaluation& evaluation);

}  // namespace facet
