// SPDX-License-Identifier: BSD-2-Clause
// `facet evaluate`: how good a trajectory is against ground truth.
#include "evaluate.h"

#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "report_scene.h"

#include "facet/eval/evaluation_json.h"
#include "facet/eval/run_evaluation.h"
#include "facet/report/report_page.h"

namespace facet {

namespace {

EvaluationOptions OptionsOf(const EvaluateArguments& arguments) {
  const auto wants = [&](const char* part) {
    return std::ranges::find(arguments.parts, part) != arguments.parts.end();
  };
  EvaluationOptions options;
  options.trajectory.alignment =
      AlignmentKindFromText(arguments.alignment).value_or(AlignmentKind::kSE3);
  options.trajectory.rpe_lengths_m = arguments.rpe_lengths_m;
  options.align_time = arguments.align_time;
  options.judge_mesh = wants("mesh");
  options.judge_planes = wants("planes");
  options.judge_consistency = wants("consistency");
  options.parts_must_exist = arguments.parts_are_named;
  return options;
}

std::string NameOf(const std::filesystem::path& result) {
  const auto clean = std::filesystem::absolute(result).lexically_normal();
  return (clean.has_filename() ? clean : clean.parent_path()).filename().string();
}

Report MakeReport(const EvaluateArguments& arguments,
                  const GroundTruth& truth,
                  std::vector<RunEvaluation> evaluations) {
  Report report;
  ReportSection& section = report.sections.emplace_back();
  section.name = NameOf(arguments.truth);
  section.truth = arguments.truth;
  const std::vector<std::string> names = ColumnNames(evaluations);
  for (std::size_t i = 0; i < evaluations.size(); ++i)
    section.runs.push_back(MakeReportRun(names[i], std::move(evaluations[i])));
  AddScene(truth, section);
  AddCameraImages(truth, section);
  report.title = "Evaluation on " + section.name;
  return report;
}

}  // namespace

void EvaluateCommand(const EvaluateArguments& arguments) {
  const EvaluationOptions options = OptionsOf(arguments);
  const GroundTruth truth = LoadGroundTruth(arguments.truth);

  std::vector<RunEvaluation> evaluations = {EvaluateRun(arguments.result, truth, options)};
  for (const std::string& other : arguments.against) {
    evaluations.push_back(EvaluateRun(other, truth, options));
  }
  for (const RunEvaluation& evaluation : evaluations) {
    for (const std::string& warning : evaluation.warnings) {
      std::cerr << "warning: " << warning << '\n';
    }
  }
  std::cout << FormatTable(evaluations);
  WriteEvaluation(evaluations.front());
  std::cout << "written: " << EvaluationFile(arguments.result).string() << '\n';
  if (arguments.report.empty()) return;
  WriteReport(arguments.report, MakeReport(arguments, truth, std::move(evaluations)));
  std::cout << "written: " << arguments.report << "/report.html\n";
}

}  // namespace facet
