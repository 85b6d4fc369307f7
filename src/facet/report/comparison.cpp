// SPDX-License-Identifier: BSD-2-Clause
#include "facet/report/comparison.h"

#include <algorithm>
#include <map>

#include "facet/eval/paired_comparison.h"
#include "facet/io/json_file.h"
#include "facet/report/paper_tables.h"
#include "facet/report/relative_error_tables.h"

namespace facet {
namespace {

using nlohmann::ordered_json;

// A figure of a run and where it is found in evaluation.json or summary.json.
struct Figure {
  const char* name;
  const char* pointer;
  bool in_summary;
};

constexpr Figure kFigures[] = {
    {"ate_rmse_m", "/ate/rmse_m", false},
    {"ate_median_m", "/ate/median_m", false},
    {"ate_keyframes_rmse_m", "/ate_keyframes/rmse_m", false},
    {"coverage", "/coverage", false},
    {"drift_percent", "/drift_percent", false},
    {"mesh_accuracy_mean_m", "/mesh/accuracy_mean_m", false},
    {"mesh_accuracy_median_m", "/mesh/accuracy_median_m", false},
    {"mesh_precision_5cm", "/mesh/precision_5cm", false},
    {"mesh_within_3m_median_m", "/mesh/within_3m/accuracy_median_m", false},
    {"mesh_within_3m_fscore_5cm", "/mesh/within_3m/fscore_5cm", false},
    {"mesh_completeness_10cm", "/mesh/completeness_10cm", false},
    {"mesh_plane_areas_rmse_m", "/mesh/plane_areas/rmse_m", false},
    {"map_accuracy_mean_m", "/map/accuracy_mean_m", false},
    {"map_accuracy_median_m", "/map/accuracy_median_m", false},
    {"map_completeness_10cm", "/map/completeness_10cm", false},
    {"map_doubled_area", "/map/doubled_area", false},
    {"planes_recall", "/planes/recall", false},
    {"planes_precision", "/planes/precision", false},
    {"cpu_mean_ms", "/stages/total_without_decode/mean_ms", true},
    {"cpu_keyframe_median_ms", "/stages/total_without_decode/keyframe_median_ms", true},
    {"optimize_keyframe_median_ms", "/stages/optimize/keyframe_median_ms", true},
    {"init_s", "/init_s", true},
    {"planes_total", "/planes_total", true},
};

std::optional<double> ValueOf(const Figure& figure, const ComparedRun& run) {
  const ordered_json& document = figure.in_summary ? run.summary : run.evaluation;
  const ordered_json::json_pointer place(figure.pointer);
  if (!run.has_result || !document.contains(place) || !document[place].is_number()) {
    return std::nullopt;
  }
  return document[place].get<double>();
}

ordered_json RunToJson(const ComparedRun& run) {
  ordered_json json = {{"start_s", run.start_s}, {"done", run.has_result}};
  if (!run.message.empty()) json["message"] = run.message;
  for (const Figure& figure : kFigures) {
    if (const auto value = ValueOf(figure, run)) json[figure.name] = *value;
  }
  return json;
}

ordered_json CombinationToJson(const ComparedCombination& combination) {
  ordered_json json = {{"name", combination.name}};
  int num_done = 0;
  for (const ComparedRun& run : combination.runs)
    num_done += run.has_result ? 1 : 0;
  json["starts"] = combination.runs.size();
  json["starts_done"] = num_done;
  for (const Figure& figure : kFigures) {
    std::vector<double> values;
    for (const ComparedRun& run : combination.runs) {
      if (const auto value = ValueOf(figure, run)) values.push_back(*value);
    }
    if (!values.empty()) json[figure.name] = Summarize(values).median;
  }
  std::vector<ordered_json> evaluations;
  for (const ComparedRun& run : combination.runs) {
    if (run.has_result) evaluations.push_back(run.evaluation);
  }
  ordered_json rpe = MedianRelativeErrors(evaluations);
  if (!rpe.empty()) json["rpe"] = std::move(rpe);
  for (const ComparedRun& run : combination.runs)
    json["runs"].push_back(RunToJson(run));
  return json;
}

ordered_json PairedToJson(const std::string& other,
                          const std::string& reference,
                          const PairedComparison& comparison) {
  return {{"other", other},
          {"reference", reference},
          {"median_ratio", comparison.median_ratio},
          {"low", comparison.low},
          {"high", comparison.high},
          {"better", comparison.num_better},
          {"pairs", comparison.ratios.size()},
          {"verdict", ToString(comparison.verdict)},
          {"ratios", comparison.ratios}};
}

// ATE of every run of a sequence on the frames that all of them have.
class CommonFrames {
 public:
  explicit CommonFrames(const ComparedSequence& sequence) {
    std::vector<std::vector<PosePair>> runs;
    std::vector<const ComparedRun*> order;
    for (const ComparedCombination& combination : sequence.combinations) {
      for (const ComparedRun& run : combination.runs) {
        if (!run.has_result || run.pairs.size() < 3) continue;
        runs.push_back(run.pairs);
        order.push_back(&run);
      }
    }
    const auto errors = ErrorsOnCommonFrames(runs, AlignmentKind::kSE3);
    if (!errors) return;
    num_frames_ = errors->num_frames;
    for (std::size_t i = 0; i < order.size(); ++i)
      rmse_m_[order[i]] = errors->rmse_m[i];
  }

  std::size_t num_frames() const { return num_frames_; }

  struct Paired {
    std::vector<double> ratios, differences_m;
  };

  Paired Compare(const ComparedCombination& reference, const ComparedCombination& other) const {
    Paired paired;
    for (std::size_t i = 0; i < std::min(reference.runs.size(), other.runs.size()); ++i) {
      const auto a = rmse_m_.find(&reference.runs[i]), b = rmse_m_.find(&other.runs[i]);
      if (a == rmse_m_.end() || b == rmse_m_.end() || !(a->second > 0)) continue;
      paired.ratios.push_back(b->second / a->second);
      paired.differences_m.push_back(b->second - a->second);
    }
    return paired;
  }

 private:
  std::size_t num_frames_ = 0;
  std::map<const ComparedRun*, double> rmse_m_;
};

// ------------------------------------------------------------------------------------- tables

std::string Place(std::size_t sequence, std::size_t combination) {
  return "/sequences/" + std::to_string(sequence) + "/combinations/" + std::to_string(combination);
}

std::string PaperText(const std::optional<double>& value) {
  return value ? FormatNumber("%.1f", *value) : "-";
}

bool AnyInPaper(const ordered_json& comparison) {
  return std::ranges::any_of(comparison["sequences"], [](const ordered_json& sequence) {
    return FindPaperRow(sequence["name"].get<std::string>()) != nullptr;
  });
}

std::vector<std::string> CombinationNames(const ordered_json& comparison) {
  std::vector<std::string> names;
  if (comparison["sequences"].empty()) return names;
  for (const auto& combination : comparison["sequences"][0]["combinations"])
    names.push_back(combination["name"]);
  return names;
}

Table TableOne(const ordered_json& comparison) {
  Table table;
  table.title = "Table I: ATE [cm], causal poses, median over the starts";
  table.header = {"sequence"};
  const bool with_paper = AnyInPaper(comparison);
  for (const std::string& name : CombinationNames(comparison)) {
    table.header.push_back(name + " median");
    table.header.push_back(name + " RMSE");
  }
  for (std::string_view name : kPaperPipelines) {
    if (!with_paper) break;
    table.header.push_back("paper " + std::string(name) + " median");
    table.header.push_back("paper " + std::string(name) + " RMSE");
  }
  const auto& sequences = comparison["sequences"];
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    auto& row = table.rows.emplace_back();
    const std::string name = sequences[s]["name"];
    row.push_back({name, "", "", 1});
    for (std::size_t c = 0; c < sequences[s]["combinations"].size(); ++c) {
      row.push_back(NumberCell(comparison, Place(s, c) + "/ate_median_m", "%.2f", 100));
      row.push_back(NumberCell(comparison, Place(s, c) + "/ate_rmse_m", "%.2f", 100));
    }
    const PaperRow* paper = FindPaperRow(name);
    for (std::size_t p = 0; with_paper && p < kPaperPipelines.size(); ++p) {
      row.push_back({paper ? PaperText(paper->median_cm[p]) : "-", "", "", 1});
      row.push_back({paper ? PaperText(paper->rmse_cm[p]) : "-", "", "", 1});
    }
  }
  if (with_paper) {
    table.notes.push_back(
        "Paper: Rosinol et al., ICRA 2019, Table I, causal keyframe poses, one run each; a dash "
        "where the paper has no legible value.");
  }
  return table;
}

Table TableTwo(const ordered_json& comparison) {
  Table table;
  table.title = "Table II: RMSE of the ATE [cm] beside other systems";
  table.header = {"sequence"};
  for (std::string_view name : kPaperSystems)
    table.header.emplace_back(name);
  for (const std::string& name : CombinationNames(comparison))
    table.header.push_back(name + " (ours)");
  const auto& sequences = comparison["sequences"];
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    const std::string name = sequences[s]["name"];
    const PaperRow* paper = FindPaperRow(name);
    if (paper == nullptr) continue;
    auto& row = table.rows.emplace_back();
    row.push_back({name, "", "", 1});
    for (const auto& value : paper->others_rmse_cm)
      row.push_back({value ? FormatNumber("%.0f", *value) : "failed", "", "", 1});
    for (std::size_t c = 0; c < sequences[s]["combinations"].size(); ++c)
      row.push_back(NumberCell(comparison, Place(s, c) + "/ate_rmse_m", "%.1f", 100));
  }
  table.notes.push_back(
      "Other systems as reported by the paper, aligned there with scale (Sim(3)); ours without.");
  return table;
}

void AddPairedRow(const ordered_json& comparison,
                  const std::string& place,
                  const std::string& sequence,
                  Table& table) {
  const ordered_json& entry = comparison[ordered_json::json_pointer(place)];
  auto& row = table.rows.emplace_back();
  row.push_back({sequence, "", "", 1});
  row.push_back({entry["other"].get<std::string>() + " / " + entry["reference"].get<std::string>(),
                 "",
                 "",
                 1});
  for (const char* key : {"/median_ratio", "/low", "/high"})
    row.push_back(NumberCell(comparison, place + key, "%.3f"));
  row.push_back(NumberCell(comparison, place + "/median_difference_m", "%+.2f", 100));
  row.push_back(NumberCell(comparison, place + "/better", "%.0f"));
  row.push_back(NumberCell(comparison, place + "/pairs", "%.0f"));
  row.push_back({entry["verdict"], "", "", 1});
}

Table PairedTable(const ordered_json& comparison) {
  Table table;
  table.title = "Paired comparison: ATE RMSE on common frames, start by start";
  table.header = {"sequence",
                  "compared",
                  "median ratio",
                  "from",
                  "to",
                  "median diff. [cm]",
                  "better in",
                  "of",
                  "verdict"};
  const auto& sequences = comparison["sequences"];
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    const std::string place = "/sequences/" + std::to_string(s) + "/paired";
    for (std::size_t p = 0; p < sequences[s]["paired"].size(); ++p)
      AddPairedRow(comparison, place + "/" + std::to_string(p), sequences[s]["name"], table);
  }
  for (std::size_t p = 0; p < comparison["pooled"].size(); ++p)
    AddPairedRow(comparison, "/pooled/" + std::to_string(p), "all sequences", table);
  table.notes = {
      "A ratio below 1: the first one is better. From, to: 95 % interval of the median "
      "ratio.",
      "A difference is real when at least 9 starts were compared and the interval "
      "excludes 1."};
  return table;
}

struct Column {
  const char* name;
  const char* key;
  const char* format;
  double factor;
};

constexpr Column kOtherColumns[] = {
    {"done", "starts_done", "%.0f", 1},
    {"of", "starts", "%.0f", 1},
    {"coverage [%]", "coverage", "%.1f", 100},
    {"first pose [s]", "init_s", "%.2f", 1},
    {"drift [%]", "drift_percent", "%.2f", 1},
    {"keyframes ATE RMSE [cm]", "ate_keyframes_rmse_m", "%.2f", 100},
    {"mesh accuracy [cm]", "mesh_accuracy_mean_m", "%.2f", 100},
    {"mesh median [cm]", "mesh_accuracy_median_m", "%.2f", 100},
    {"mesh area within 5 cm [%]", "mesh_precision_5cm", "%.1f", 100},
    {"mesh within 3 m, median [cm]", "mesh_within_3m_median_m", "%.2f", 100},
    {"mesh within 3 m, F-score 5 cm [%]", "mesh_within_3m_fscore_5cm", "%.1f", 100},
    {"mesh complete 10 cm [%]", "mesh_completeness_10cm", "%.1f", 100},
    {"mesh on planes, RMSE [cm]", "mesh_plane_areas_rmse_m", "%.2f", 100},
    {"map accuracy [cm]", "map_accuracy_mean_m", "%.2f", 100},
    {"map median [cm]", "map_accuracy_median_m", "%.2f", 100},
    {"map complete 10 cm [%]", "map_completeness_10cm", "%.1f", 100},
    {"map doubled area [%]", "map_doubled_area", "%.2f", 100},
    {"planes recall [%]", "planes_recall", "%.1f", 100},
    {"planes precision [%]", "planes_precision", "%.1f", 100},
    {"CPU per frame [ms]", "cpu_mean_ms", "%.1f", 1},
    {"CPU per keyframe [ms]", "cpu_keyframe_median_ms", "%.1f", 1},
    {"optimize per keyframe [ms]", "optimize_keyframe_median_ms", "%.1f", 1},
};

Table OtherFigures(const ordered_json& comparison) {
  std::vector<Column> columns;  // those that any combination has
  for (const Column& column : kOtherColumns) {
    bool any = false;
    for (const auto& sequence : comparison["sequences"]) {
      for (const auto& combination : sequence["combinations"])
        any = any || combination.contains(column.key);
    }
    if (any) columns.push_back(column);
  }
  Table table;
  table.title = "Other figures, medians over the starts";
  table.header = {"sequence", "combination"};
  for (const Column& column : columns)
    table.header.emplace_back(column.name);
  const auto& sequences = comparison["sequences"];
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    for (std::size_t c = 0; c < sequences[s]["combinations"].size(); ++c) {
      auto& row = table.rows.emplace_back();
      row.push_back({sequences[s]["name"], "", "", 1});
      row.push_back({sequences[s]["combinations"][c]["name"], "", "", 1});
      for (const Column& column : columns) {
        row.push_back(
            NumberCell(comparison, Place(s, c) + "/" + column.key, column.format, column.factor));
      }
    }
  }
  table.notes.push_back("CPU: thread time without image decoding, one core per run.");
  return table;
}

// Runs with a complaint; those with the same one of a combination share a line.
Table ComplaintTable(const ordered_json& comparison, bool with_result) {
  Table table;
  table.title =
      with_result ? "Runs that ended early or were judged in part only" : "Runs without a result";
  table.header = {"sequence", "combination", "runs", "reason"};
  for (const auto& sequence : comparison["sequences"]) {
    for (const auto& combination : sequence["combinations"]) {
      std::map<std::string, int> count;
      for (const auto& run : combination["runs"]) {
        const bool complains = !with_result || run.contains("message");
        if (run["done"].get<bool>() == with_result && complains) {
          ++count[run.value("message", "no message")];
        }
      }
      for (const auto& [message, number] : count) {
        table.rows.push_back({{sequence["name"], "", "", 1},
                              {combination["name"], "", "", 1},
                              {std::to_string(number), "", "", 1},
                              {message, "", "", 1}});
      }
    }
  }
  return table;
}

}  // namespace

nlohmann::ordered_json CompareToJson(const std::vector<ComparedSequence>& sequences) {
  ordered_json json;
  json["sequences"] = ordered_json::array();
  std::map<std::string, CommonFrames::Paired> pooled;
  std::string reference;
  std::vector<std::string> order;
  for (const ComparedSequence& sequence : sequences) {
    ordered_json entry = {{"name", sequence.name}};
    for (const ComparedCombination& combination : sequence.combinations)
      entry["combinations"].push_back(CombinationToJson(combination));
    entry["rpe_gains"] = RelativeErrorGains(entry["combinations"]);
    const CommonFrames frames(sequence);
    entry["common_frames"] = frames.num_frames();
    entry["paired"] = ordered_json::array();
    for (std::size_t c = 1; c < sequence.combinations.size(); ++c) {
      const ComparedCombination& first = sequence.combinations.front();
      const ComparedCombination& other = sequence.combinations[c];
      const CommonFrames::Paired paired = frames.Compare(first, other);
      if (paired.ratios.empty()) continue;
      reference = first.name;
      if (std::ranges::find(order, other.name) == order.end()) order.push_back(other.name);
      entry["paired"].push_back(PairedToJson(other.name, first.name, CompareRatios(paired.ratios)));
      entry["paired"].back()["median_difference_m"] = Summarize(paired.differences_m).median;
      auto& pool = pooled[other.name];
      pool.ratios.insert(pool.ratios.end(), paired.ratios.begin(), paired.ratios.end());
      pool.differences_m.insert(
          pool.differences_m.end(), paired.differences_m.begin(), paired.differences_m.end());
    }
    json["sequences"].push_back(entry);
  }
  json["pooled"] = ordered_json::array();
  for (const std::string& name : order) {
    if (sequences.size() < 2) break;
    json["pooled"].push_back(PairedToJson(name, reference, CompareRatios(pooled[name].ratios)));
    json["pooled"].back()["median_difference_m"] = Summarize(pooled[name].differences_m).median;
  }
  return json;
}

std::vector<Table> ComparisonTables(const nlohmann::ordered_json& comparison) {
  std::vector<Table> tables = {TableOne(comparison)};
  if (AnyInPaper(comparison)) tables.push_back(TableTwo(comparison));
  if (Table paired = PairedTable(comparison); !paired.rows.empty())
    tables.push_back(std::move(paired));
  for (Table& table : RelativeErrorTables(comparison))
    tables.push_back(std::move(table));
  for (Table& table : std::vector<Table>{OtherFigures(comparison),
                                         ComplaintTable(comparison, false),
                                         ComplaintTable(comparison, true)}) {
    if (!table.rows.empty()) tables.push_back(std::move(table));
  }
  return tables;
}

std::string RunsCsv(const nlohmann::ordered_json& comparison) {
  Table table;
  table.header = {"sequence", "combination", "start_s", "done"};
  for (const Figure& figure : kFigures)
    table.header.emplace_back(figure.name);
  table.header.emplace_back("message");
  for (const auto& sequence : comparison["sequences"]) {
    for (const auto& combination : sequence["combinations"]) {
      for (const auto& run : combination["runs"]) {
        auto& row = table.rows.emplace_back();
        const auto add = [&row](const std::string& text) { row.push_back({text, "", "", 1}); };
        add(sequence["name"]);
        add(combination["name"]);
        add(FormatNumber("%g", run["start_s"].get<double>()));
        add(run["done"].get<bool>() ? "1" : "0");
        for (const Figure& figure : kFigures)
          add(run.contains(figure.name) ? JsonText(run[figure.name]) : "");
        add(run.value("message", ""));
      }
    }
  }
  const std::string csv = ToCsv(table);
  return csv.substr(csv.find('\n') + 1);  // without the line of the title
}

}  // namespace facet
