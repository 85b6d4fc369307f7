// SPDX-License-Identifier: BSD-2-Clause
// The result of `facet compare`: many runs of the same sequences, as one JSON document and as the
// tables that are read out of it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "facet/eval/trajectory_error.h"
#include "facet/report/table.h"

namespace facet {

/// One run of one combination of pipeline and configuration, from one start.
struct ComparedRun {
  double start_s = 0;
  bool has_result = false;
  std::string message;  ///< why there is no result, or only a part of it
  std::filesystem::path folder;
  std::vector<PosePair> pairs;        ///< causal poses with their truth
  nlohmann::ordered_json evaluation;  ///< evaluation.json
  nlohmann::ordered_json summary;     ///< summary.json
};

/// A pipeline with a configuration: a column of the tables.
struct ComparedCombination {
  std::string name;
  std::vector<ComparedRun> runs;  ///< by start, the same starts for all combinations
};

struct ComparedSequence {
  std::string name;
  std::vector<ComparedCombination> combinations;  ///< the same names in each sequence
};

/// comparison.json: per sequence and combination medians over the starts and every run; the other
/// combinations against the first one, start by start on the frames that all runs of the sequence
/// have; the same over all sequences.
nlohmann::ordered_json CompareToJson(const std::vector<ComparedSequence>& sequences);

/// Table I (with the paper's values where the sequence is in the paper), Table II where any is, the
/// paired comparison, cost, meshes and planes where there are any, and what failed.
std::vector<Table> ComparisonTables(const nlohmann::ordered_json& comparison);

/// One line per run, for other programs: sequence, combination, start_s, done, the figures in SI
/// units (empty where there is none), message.
std::string RunsCsv(const nlohmann::ordered_json& comparison);

}  // namespace facet
