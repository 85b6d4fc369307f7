// SPDX-License-Identifier: BSD-2-Clause
// `facet evaluate`: how good a trajectory is against ground truth.
#include "evaluate.h"

#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "facet/eval/run_evaluation.h"

namespace facet {

namespace {

struct EvaluateArguments {
  std::string result;
  std::string truth;
  std::vector<std::string> against;
  std::vector<double> rpe_lengths_m;
  std::string alignment = ToString(AlignmentKind::kSE3);
};

void Evaluate(const EvaluateArguments& arguments) {
  TrajectoryErrorOptions options;
  options.alignment = AlignmentKindFromText(arguments.alignment).value_or(AlignmentKind::kSE3);
  options.rpe_lengths_m = arguments.rpe_lengths_m;
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
}

}  // namespace

void AddEvaluateCommand(CLI::App& app) {
  auto* command = app.add_subcommand("evaluate", "Judge a trajectory against ground truth");
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
      ->check(CLI::PositiveNumber);
  command->callback([arguments] { Evaluate(*arguments); });
}

}  // namespace facet
