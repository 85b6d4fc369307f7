// SPDX-License-Identifier: BSD-2-Clause
// `facet evaluate` without the command line: reads a result and a ground truth, computes every
// figure there is truth for, and prints them as JSON and as a table. Throws InputError for what
// cannot be judged.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "facet/eval/trajectory_error.h"

namespace facet {

struct GroundTruth {
  std::filesystem::path path;
  std::vector<StampedPose> poses;
  std::vector<Timestamp> frames;  ///< stamps of the left images; empty when the truth is one file
};

/// A sequence folder (holds mav0/, or is it), or a trajectory file (TUM or EuRoC csv).
GroundTruth LoadGroundTruth(const std::filesystem::path& sequence_or_file);

struct RunEvaluation {
  std::filesystem::path result;
  AlignmentKind alignment = AlignmentKind::kSE3;
  std::optional<double> coverage;  ///< share of the stereo frames that have a pose
  TrajectoryError causal;
  std::optional<TrajectoryError> keyframes;
  std::vector<std::string> warnings;
};

/// A result folder of `facet run`, or a trajectory file of any system.
RunEvaluation EvaluateRun(const std::filesystem::path& result,
                          const GroundTruth& truth,
                          const TrajectoryErrorOptions& options);

/// The content of evaluation.json: parts without ground truth are absent.
nlohmann::ordered_json ToJson(const RunEvaluation& evaluation);

/// RESULT/evaluation.json, or <file>.evaluation.json beside a trajectory file.
std::filesystem::path EvaluationFile(const std::filesystem::path& result);

/// Writes the file as a whole or not at all; throws OutputError.
void WriteEvaluation(const RunEvaluation& evaluation);

/// One column per run, for a terminal.
std::string FormatTable(std::span<const RunEvaluation> evaluations);

}  // namespace facet
