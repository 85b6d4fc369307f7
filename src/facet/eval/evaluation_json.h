// SPDX-License-Identifier: BSD-2-Clause
// An evaluation as evaluation.json and as a table for a terminal.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "facet/eval/run_evaluation.h"

namespace facet {

/// The content of evaluation.json: parts without ground truth are absent.
nlohmann::ordered_json ToJson(const RunEvaluation& evaluation);

/// Names for the runs' columns: the end of each path, as much of it as tells them apart. The same
/// path twice has the same name.
std::vector<std::string> ColumnNames(std::span<const RunEvaluation> evaluations);

/// One column per run.
std::string FormatTable(std::span<const RunEvaluation> evaluations);

}  // namespace facet
