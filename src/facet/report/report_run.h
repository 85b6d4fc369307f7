// SPDX-License-Identifier: BSD-2-Clause
// What a report needs to know about one run.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "facet/eval/run_evaluation.h"
#include "facet/io/config_file.h"

namespace facet {

/// Columns of numbers by name; what is not a number is nan.
using NumberColumns = std::map<std::string, std::vector<double>>;

struct ReportRun {
  std::string name;
  RunEvaluation evaluation;
  nlohmann::ordered_json evaluation_json;
  nlohmann::ordered_json summary;   ///< summary.json; empty for a trajectory of another system
  NumberColumns timing;             ///< timing.csv
  std::vector<ConfigEntry> config;  ///< config.yaml
};

/// The first line of the file names the columns. A file that is not there has none.
NumberColumns ReadNumberColumns(const std::filesystem::path& csv);

/// Reads what lies beside the trajectory; files that are absent or damaged leave their part empty.
ReportRun MakeReportRun(std::string name, RunEvaluation evaluation);

}  // namespace facet
