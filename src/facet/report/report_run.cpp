// SPDX-License-Identifier: BSD-2-Clause
#include "facet/report/report_run.h"

#include <fstream>
#include <limits>
#include <sstream>

#include "facet/eval/evaluation_json.h"
#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"
#include "facet/io/json_file.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

}  // namespace

NumberColumns ReadNumberColumns(const std::filesystem::path& csv) {
  NumberColumns columns;
  std::error_code error;
  if (!fs::is_regular_file(csv, error)) return columns;  // nobody may ever write to a pipe
  std::ifstream stream(csv);
  std::string line;
  if (!std::getline(stream, line)) return columns;
  std::vector<std::vector<double>*> order;
  std::istringstream names(line);
  std::string name;
  while (std::getline(names, name, ','))
    order.push_back(&columns[std::string(Trim(name))]);
  while (std::getline(stream, line)) {
    std::istringstream fields(line);
    std::string field;
    for (std::vector<double>* column : order) {
      if (!std::getline(fields, field, ',')) field.clear();
      column->push_back(
          ParseDouble(Trim(field)).value_or(std::numeric_limits<double>::quiet_NaN()));
    }
  }
  return columns;
}

ReportRun MakeReportRun(std::string name, RunEvaluation evaluation) {
  ReportRun run;
  run.name = std::move(name);
  run.evaluation_json = ToJson(evaluation);
  run.summary = nlohmann::ordered_json::object();
  const fs::path folder = evaluation.result;
  run.evaluation = std::move(evaluation);
  if (!fs::is_directory(folder)) return run;
  nlohmann::ordered_json summary = ReadJsonFile(folder / "summary.json");
  if (summary.is_object()) run.summary = std::move(summary);
  run.timing = ReadNumberColumns(folder / "timing.csv");
  try {
    if (fs::exists(folder / "config.yaml")) run.config = ReadConfigFile(folder / "config.yaml");
  } catch (const ConfigError&) {
    run.config.clear();  // a report without its list of parameters is still a report
  }
  return run;
}

}  // namespace facet
