// SPDX-License-Identifier: BSD-2-Clause
// `facet evaluate`: how good a trajectory is against ground truth.
#include "evaluate.h"

#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "number_check.h"
#include <CLI/CLI.hpp>

#include "facet/eval/evaluation_json.h"
#include "facet/eval/run_evaluation.h"
#include "facet/report/report_page.h"

namespace facet {

namespace {

struct EvaluateArguments {
  std::string result;
  std::string truth;
  std::vector<std::string> against;
  std::vector<double> rpe_lengths_m;
  std::string alignment = ToString(AlignmentKind::kSE3);
  std::vector<std::string> parts = {"mesh", "planes", "consistency"};
  bool parts_are_named = false;
  bool align_time = false;
  std::string report;
};

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

Report MakeReport(const EvaluateArguments& arguments, std::vector<RunEvaluation> evaluations) {
  Report report;
  ReportSection& section = report.sections.emplace_back();
  section.name = NameOf(arguments.truth);
  section.truth = arguments.truth;
  const std::vector<std::string> names = ColumnNames(evaluations);
  for (std::size_t i = 0; i < evaluations.size(); ++i)
    section.runs.push_back(MakeReportRun(names[i], std::move(evaluations[i])));
  report.title = "Evaluation on " + section.name;
  return report;
}

void Evaluate(const EvaluateArguments& arguments) {
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
  WriteReport(arguments.report, MakeReport(arguments, std::move(evaluations)));
  std::cout << "written: " << arguments.report << "/report.html\n";
}

}  // namespace

void AddEvaluateCommand(CLI::App& app) {
  auto* command =
      app.add_subcommand("evaluate", "Judge a trajectory, meshes and planes against ground truth");
  auto arguments = std::make_shared<EvaluateArguments>();
  command
      ->add_option(
          "RESULT", arguments->result, "result folder, or trajectory file (TUM, EuRoC csv)")
      ->required();
  command->add_option("--truth", arguments->truth, "sequence folder, or trajectory file")
      ->required();
  command->add_option("--against", arguments->against, "more results, for comparison in the table");
  command
      ->add_option("--alignment", arguments->alignment, "se3, yaw (rotation about z only) or sim3")
      ->check(CLI::IsMember({"se3", "yaw", "sim3"}))
      ->capture_default_str();
  command
      ->add_option(
          "--rpe-lengths",
          arguments->rpe_lengths_m,
          "path lengths [m] for relative errors; default: 1,2,5,10,20,... as far as the path goes")
      ->delimiter(',')
      ->check(PositiveNumber());
  command->add_option(
      "--report", arguments->report, "folder for report.html: plots and tables on one page");
  command->add_flag("--align-time",
                    arguments->align_time,
                    "estimate the offset between the two clocks (at most 0.5 s) and remove it");
  command
      ->add_option(
          "--parts",
          arguments->parts,
          "what to judge beside the trajectory, where there is truth for it: "
          "mesh,planes,consistency (default), or trajectory for nothing else; what is named "
          "must be there")
      ->delimiter(',')
      ->check(CLI::IsMember({"trajectory", "mesh", "planes", "consistency"}));
  command->callback([arguments, command] {
    arguments->parts_are_named = command->count("--parts") > 0;
    Evaluate(*arguments);
  });
}

}  // namespace facet
