// SPDX-License-Identifier: BSD-2-Clause
// An evaluation as evaluation.json and as a table for a terminal.
#pragma once

#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "facet/eval/run_evaluation.h"

namespace facet {

/// The content of evaluation.json: parts without ground truth are absent.
nlohmann::ordered_json ToJson(const RunEvaluation& evaluation);

/// One column per run.
std::string FormatTable(std::span<const RunEvaluation> evaluations);

}  // namespace facet
