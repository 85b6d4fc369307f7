// SPDX-License-Identifier: BSD-2-Clause
// `facet compare`: sequences x pipelines x configurations x starts, and what of the differences is
// real.
#include "compare.h"

#include <iostream>
#include <set>
#include <string>
#include <vector>

#include "compare_runs.h"
#include "load_options.h"
#include "report_scene.h"
#include "run.h"
#include "slurm_runs.h"

#include "facet/eval/ground_truth.h"
#include "facet/io/asl_dataset.h"
#include "facet/io/errors.h"
#include "facet/io/json_file.h"
#include "facet/io/text_file.h"
#include "facet/report/comparison.h"
#include "facet/report/report_page.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct NamedConfig {
  std::string name, file;
};

struct Combination {
  std::string name;
  std::vector<std::string> arguments;
};

std::vector<NamedConfig> ParseConfigs(const CompareArguments& arguments) {
  std::vector<NamedConfig> configs;
  std::set<std::string> names;
  for (const std::string& text : arguments.configs) {
    const std::size_t equals = text.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == text.size()) {
      throw ConfigError("--config " + text + ": NAME=FILE is expected");
    }
    NamedConfig config{text.substr(0, equals), text.substr(equals + 1)};
    if (config.name.find('/') != std::string::npos || !names.insert(config.name).second) {
      throw ConfigError("--config " + text + ": the name must be new and without '/'");
    }
    LoadOptions(config.file, arguments.overrides);  // refuses a bad file before the first run
    configs.push_back(std::move(config));
  }
  if (configs.empty()) LoadOptions("", arguments.overrides);
  return configs;
}

// Horizon meshes are judged on those of every 10th keyframe; `facet run` takes the option only
// once.
std::vector<std::string> RunOptions(const CompareArguments& arguments) {
  std::vector<std::string> options = arguments.run_options;
  const auto is_mesh_every = [](const std::string& option) {
    return option == "--mesh-every" || option.starts_with("--mesh-every=");
  };
  if (std::ranges::none_of(options, is_mesh_every)) options.emplace_back("--mesh-every=10");
  return options;
}

std::vector<Combination> Combinations(const CompareArguments& arguments) {
  std::vector<std::string> common = RunOptions(arguments);
  for (const std::string& text : arguments.overrides)
    common.insert(common.end(), {"--set", text});
  if (arguments.duration_s > 0) {
    common.insert(common.end(), {"--duration", std::to_string(arguments.duration_s)});
  }
  const std::vector<NamedConfig> configs = ParseConfigs(arguments);
  std::vector<Combination> combinations;
  for (const std::string& pipeline : arguments.pipelines) {
    Combination plain{pipeline, {"--pipeline", pipeline}};
    plain.arguments.insert(plain.arguments.end(), common.begin(), common.end());
    if (configs.empty()) combinations.push_back(plain);
    for (const NamedConfig& config : configs) {
      Combination named = plain;
      named.name += "-" + config.name;
      named.arguments.insert(named.arguments.end(), {"--config", config.file});
      combinations.push_back(named);
    }
  }
  return combinations;
}

struct NamedSequence {
  std::string name;
  fs::path path;
  std::vector<StampedPose> truth;
};

// The folder that holds mav0/, by the name that the user gave it (links are not followed).
fs::path SequenceFolder(const std::string& text) {
  fs::path folder = fs::absolute(text).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  return folder.filename() == "mav0" ? folder.parent_path() : folder;
}

std::vector<NamedSequence> OpenSequences(const CompareArguments& arguments) {
  std::vector<NamedSequence> sequences;
  std::set<std::string> names;
  for (const std::string& text : arguments.sequences) {
    FindMav0(text);  // throws where there is no sequence
    const fs::path folder = SequenceFolder(text);
    NamedSequence sequence{folder.filename().string(), folder, LoadGroundTruth(folder).poses};
    if (!names.insert(sequence.name).second) {
      throw ConfigError(text + ": another sequence has the name '" + sequence.name + "', too");
    }
    sequences.push_back(std::move(sequence));
  }
  return sequences;
}

std::string StartName(int k) {
  char text[32];
  std::snprintf(text, sizeof(text), "start_%d.%d", k / 10, k % 10);
  return text;
}

// Start by start, so that slow spells of the machine hit all combinations alike.
std::vector<RunCell> MakeCells(const CompareArguments& arguments,
                               const std::vector<NamedSequence>& sequences,
                               const std::vector<Combination>& combinations) {
  std::vector<RunCell> cells;
  for (const NamedSequence& sequence : sequences) {
    for (int k = 0; k < arguments.starts; ++k) {
      for (const Combination& combination : combinations) {
        RunCell& cell = cells.emplace_back();
        cell.sequence = sequence.path;
        cell.sequence_name = sequence.name;
        cell.combination = combination.name;
        cell.start_s = 0.1 * k;
        cell.arguments = combination.arguments;
        cell.folder = fs::path(arguments.out) / sequence.name / combination.name / StartName(k);
      }
    }
  }
  return cells;
}

ordered_json ReadObject(const fs::path& file) {
  ordered_json json = ReadJsonFile(file);
  return json.is_object() ? json : ordered_json::object();
}

ComparedRun Load(const RunCell& cell, const NamedSequence& sequence) {
  ComparedRun run;
  run.start_s = cell.start_s;
  run.has_result = cell.has_result;
  run.message = cell.message;
  run.folder = cell.folder;
  if (!cell.has_result) return run;
  run.evaluation = ReadObject(cell.folder / "evaluation.json");
  run.summary = ReadObject(cell.folder / "summary.json");
  run.pairs = Associate(ReadTrajectory(cell.folder / "trajectory.tum").poses, sequence.truth).pairs;
  return run;
}

std::vector<ComparedSequence> Collect(const std::vector<RunCell>& cells,
                                      const std::vector<NamedSequence>& sequences,
                                      const std::vector<Combination>& combinations) {
  std::vector<ComparedSequence> compared;
  for (const NamedSequence& sequence : sequences) {
    ComparedSequence& entry = compared.emplace_back();
    entry.name = sequence.name;
    for (const Combination& combination : combinations) {
      ComparedCombination& column = entry.combinations.emplace_back();
      column.name = combination.name;
      for (const RunCell& cell : cells) {
        if (cell.sequence_name == sequence.name && cell.combination == combination.name) {
          column.runs.push_back(Load(cell, sequence));
        }
      }
    }
  }
  return compared;
}

void WriteTables(const fs::path& out, const ordered_json& comparison) {
  std::string csv, markdown;
  for (const Table& table : ComparisonTables(comparison)) {
    std::cout << ToText(table) << '\n';
    csv += ToCsv(table) + '\n';
    markdown += ToMarkdown(table);
  }
  ReplaceTextFile(out / "comparison.json", JsonText(comparison, 1) + "\n");
  ReplaceTextFile(out / "comparison.csv", csv);
  ReplaceTextFile(out / "comparison.md", markdown);
  ReplaceTextFile(out / "runs.csv", RunsCsv(comparison));
}

// The first start of every combination that has one stands for it in the figures.
ReportSection MakeSection(const NamedSequence& sequence, const ComparedSequence& compared) {
  ReportSection section;
  section.name = sequence.name;
  section.truth = sequence.path.string();
  section.remark = " Figures and numbers of the first start of each combination.";
  const GroundTruth truth = LoadGroundTruth(sequence.path);
  for (const ComparedCombination& combination : compared.combinations) {
    const auto run = std::ranges::find_if(combination.runs, &ComparedRun::has_result);
    if (run == combination.runs.end()) continue;
    section.runs.push_back(MakeReportRun(combination.name, EvaluateRun(run->folder, truth, {})));
  }
  AddScene(truth, section);
  AddCameraImages(truth, section);
  return section;
}

Report MakeReport(const std::vector<NamedSequence>& sequences,
                  const std::vector<ComparedSequence>& compared,
                  const ordered_json& comparison) {
  Report report;
  report.title = "Comparison";
  report.comparison = comparison;
  for (std::size_t i = 0; i < sequences.size(); ++i) {
    ReportSection section = MakeSection(sequences[i], compared[i]);
    if (!section.runs.empty()) report.sections.push_back(std::move(section));
  }
  return report;
}

}  // namespace

void CompareCommand(const CompareArguments& arguments) {
  const std::vector<NamedSequence> sequences = OpenSequences(arguments);
  const std::vector<Combination> combinations = Combinations(arguments);
  std::error_code error;
  fs::create_directories(arguments.out, error);
  if (error) {
    throw ConfigError("--out " + arguments.out + ": cannot be created: " + error.message());
  }
  std::vector<RunCell> cells = MakeCells(arguments, sequences, combinations);
  if (arguments.cell >= 0) {
    if (arguments.cell >= static_cast<int>(cells.size())) {
      throw ConfigError("--cell: the study has " + std::to_string(cells.size()) + " runs");
    }
    ExecuteCell(cells[static_cast<std::size_t>(arguments.cell)]);
    return;
  }
  if (arguments.uses_slurm) {
    ExecuteOnSlurm(cells,
                   {arguments.out, arguments.jobs, arguments.slurm_options, arguments.is_quiet});
  } else {
    ExecuteCells(cells, arguments.jobs, arguments.is_quiet);
  }
  const std::vector<ComparedSequence> compared = Collect(cells, sequences, combinations);
  const ordered_json comparison = CompareToJson(compared);
  WriteTables(arguments.out, comparison);
  std::cout << "written: " << arguments.out << "/comparison.{json,csv,md,html}, runs.csv\n";
  const Report report = MakeReport(sequences, compared, comparison);
  ReplaceTextFile(fs::path(arguments.out) / "comparison.html", ReportHtml(report));
  if (!arguments.report.empty()) {
    WriteReport(arguments.report, report);
    std::cout << "written: " << arguments.report << "/report.html\n";
  }
  if (std::ranges::none_of(cells, &RunCell::has_result)) {
    constexpr int kEstimator = 4;
    throw RunEndedError(kEstimator, "no run has a result: " + cells.front().message);
  }
}

}  // namespace facet
