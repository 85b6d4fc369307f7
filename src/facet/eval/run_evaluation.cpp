// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/run_evaluation.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <numbers>

#include <nlohmann/json.hpp>

#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"

namespace facet {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
// A pose belongs to a frame when their stamps differ by less than this.
constexpr Duration kSameFrame{1'000'000};

std::vector<Timestamp> ReadFrameStamps(const fs::path& file) {
  std::vector<Timestamp> stamps;
  if (!fs::exists(file)) return stamps;
  CsvReader row(file);
  while (row.Next()) {
    if (const auto ns = ParseInteger(row.fields().front())) stamps.push_back({*ns});
  }
  std::sort(stamps.begin(), stamps.end());
  return stamps;
}

// Stereo frames of the run as `facet run` counted them; empty without a readable summary.
std::optional<int> FramesOfSummary(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream) return std::nullopt;
  const auto summary = ordered_json::parse(stream, nullptr, false);
  if (!summary.is_object() || !summary.contains("frames")) return std::nullopt;
  const auto& frames = summary["frames"];
  if (!frames.is_number_integer() || frames.get<int>() <= 0) return std::nullopt;
  return frames.get<int>();
}

std::size_t CountFramesWithPose(std::span<const Timestamp> frames,
                                std::span<const StampedPose> poses) {
  return static_cast<std::size_t>(std::ranges::count_if(frames, [&](Timestamp t) {
    const auto pose = std::ranges::lower_bound(poses, t - kSameFrame, {}, &StampedPose::t);
    return pose != poses.end() && pose->t <= t + kSameFrame;
  }));
}

std::optional<double> Coverage(const fs::path& result,
                               std::span<const StampedPose> poses,
                               const GroundTruth& truth) {
  if (const auto frames = FramesOfSummary(result / "summary.json")) {
    return static_cast<double>(poses.size()) / *frames;
  }
  if (truth.frames.empty()) return std::nullopt;
  return static_cast<double>(CountFramesWithPose(truth.frames, poses)) /
         static_cast<double>(truth.frames.size());
}

fs::path TrajectoryFile(const fs::path& result) {
  if (!fs::exists(result)) throw InputError(result.string() + ": there is no such file or folder");
  if (!fs::is_directory(result)) return result;
  fs::path file = result / "trajectory.tum";
  if (!fs::exists(file)) {
    throw InputError(file.string() + ": there is no such file; is '" + result.string() +
                     "' a result folder of 'facet run'?");
  }
  return file;
}

// A run that ended early may have too few keyframes; the rest of the evaluation stands without
// them.
void EvaluateKeyframes(const fs::path& result,
                       const GroundTruth& truth,
                       const TrajectoryErrorOptions& options,
                       RunEvaluation& evaluation) {
  const fs::path file = result / "keyframes.tum";
  if (!fs::is_directory(result) || !fs::exists(file)) return;
  try {
    const Trajectory keyframes = ReadTrajectory(file);
    const std::string problem = WhatIsWrong(keyframes.poses, truth.poses);
    if (!problem.empty()) throw InputError(file.string() + ": " + problem);
    evaluation.keyframes = EvaluateTrajectory(keyframes.poses, truth.poses, options);
  } catch (const InputError& error) {
    evaluation.warnings.push_back(std::string(error.what()) + "; keyframes are not judged");
  }
}

ordered_json ToJson(const ErrorStatistics& s) {
  return {{"rmse_m", s.rmse}, {"median_m", s.median}, {"mean_m", s.mean}, {"max_m", s.max}};
}

ordered_json ToJson(const RelativeErrors& errors) {
  const ErrorStatistics translation = Summarize(errors.translation_m);
  const ErrorStatistics rotation = Summarize(errors.rotation_rad);
  return {{"length_m", errors.length_m},
          {"translation_median_m", translation.median},
          {"translation_rmse_m", translation.rmse},
          {"rotation_median_deg", rotation.median * kDegPerRad},
          {"rotation_rmse_deg", rotation.rmse * kDegPerRad},
          {"pairs", errors.translation_m.size()}};
}

ordered_json ToJson(const TrajectoryAlignment& alignment, AlignmentKind kind) {
  const Quaterniond& q = alignment.T_GW.q;
  const Vector3d& p = alignment.T_GW.p;
  return {{"kind", ToString(kind)},
          {"translation_m", {p.x(), p.y(), p.z()}},
          {"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}},
          {"scale", alignment.scale}};
}

std::string Text(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

// Rows of the table in order: name and the text of one run.
std::vector<std::pair<std::string, std::string>> Rows(const RunEvaluation& e) {
  std::vector<std::pair<std::string, std::string>> rows;
  rows.emplace_back("poses with truth", std::to_string(e.causal.num_pairs));
  if (e.coverage) rows.emplace_back("coverage [%]", Text("%.1f", 100 * *e.coverage));
  rows.emplace_back("path [m]", Text("%.2f", e.causal.path_length_m));
  rows.emplace_back("ATE rmse [m]", Text("%.4f", e.causal.ate_m.rmse));
  rows.emplace_back("ATE median [m]", Text("%.4f", e.causal.ate_m.median));
  rows.emplace_back("ATE mean [m]", Text("%.4f", e.causal.ate_m.mean));
  rows.emplace_back("ATE max [m]", Text("%.4f", e.causal.ate_m.max));
  if (e.keyframes) {
    rows.emplace_back("ATE rmse, keyframes [m]", Text("%.4f", e.keyframes->ate_m.rmse));
  }
  for (const RelativeErrors& errors : e.causal.rpe) {
    const std::string name = "RPE " + Text("%g", errors.length_m) + " m, median";
    rows.emplace_back(name + " [m]", Text("%.4f", Summarize(errors.translation_m).median));
    rows.emplace_back(name + " [deg]",
                      Text("%.3f", Summarize(errors.rotation_rad).median * kDegPerRad));
  }
  if (e.causal.drift_percent) rows.emplace_back("drift [%]", Text("%.2f", *e.causal.drift_percent));
  if (e.causal.scale_error_percent) {
    rows.emplace_back("scale error [%]", Text("%+.2f", *e.causal.scale_error_percent));
  }
  return rows;
}

std::string ShortName(const fs::path& result) {
  const fs::path clean = result.has_filename() ? result : result.parent_path();
  return clean.filename().string();
}

std::string Pad(const std::string& text, std::size_t width, bool right) {
  const std::string blanks(text.size() < width ? width - text.size() : 0, ' ');
  return right ? blanks + text : text + blanks;
}

}  // namespace

GroundTruth LoadGroundTruth(const std::filesystem::path& sequence_or_file) {
  GroundTruth truth;
  truth.path = sequence_or_file;
  if (!fs::is_directory(sequence_or_file)) {
    truth.poses = ReadTrajectory(sequence_or_file).poses;
    return truth;
  }
  const fs::path inside = sequence_or_file / "mav0";
  const fs::path mav0 = fs::is_directory(inside) ? inside : sequence_or_file;
  const fs::path file = mav0 / "state_groundtruth_estimate0" / "data.csv";
  if (!fs::exists(file)) {
    throw InputError(file.string() + ": there is no such file; the sequence has no ground truth");
  }
  truth.poses = ReadTrajectory(file).poses;
  truth.frames = ReadFrameStamps(mav0 / "cam0" / "data.csv");
  return truth;
}

RunEvaluation EvaluateRun(const std::filesystem::path& result,
                          const GroundTruth& truth,
                          const TrajectoryErrorOptions& options) {
  const Trajectory trajectory = ReadTrajectory(TrajectoryFile(result));
  const std::string problem = WhatIsWrong(trajectory.poses, truth.poses);
  if (!problem.empty()) throw InputError(result.string() + ": " + problem);
  RunEvaluation evaluation;
  evaluation.result = result;
  evaluation.alignment = options.alignment;
  evaluation.warnings = trajectory.warnings;
  evaluation.coverage = Coverage(result, trajectory.poses, truth);
  evaluation.causal = EvaluateTrajectory(trajectory.poses, truth.poses, options);
  EvaluateKeyframes(result, truth, options, evaluation);
  return evaluation;
}

nlohmann::ordered_json ToJson(const RunEvaluation& e) {
  ordered_json json;
  if (e.coverage) json["coverage"] = *e.coverage;
  json["poses_with_truth"] = e.causal.num_pairs;
  json["poses_without_truth"] = e.causal.num_outside + e.causal.num_in_gaps;
  json["path_length_m"] = e.causal.path_length_m;
  json["alignment"] = ToJson(e.causal.alignment, e.alignment);
  json["ate"] = ToJson(e.causal.ate_m);
  if (e.keyframes) json["ate_keyframes"] = ToJson(e.keyframes->ate_m);
  json["rpe"] = ordered_json::array();
  for (const RelativeErrors& errors : e.causal.rpe) {
    json["rpe"].push_back(ToJson(errors));
  }
  if (e.causal.drift_percent) json["drift_percent"] = *e.causal.drift_percent;
  if (e.causal.scale_error_percent) json["scale_error_percent"] = *e.causal.scale_error_percent;
  json["warnings"] = e.warnings;
  return json;
}

std::filesystem::path EvaluationFile(const std::filesystem::path& result) {
  if (fs::is_directory(result)) return result / "evaluation.json";
  return result.string() + ".evaluation.json";
}

void WriteEvaluation(const RunEvaluation& evaluation) {
  const fs::path file = EvaluationFile(evaluation.result);
  const fs::path partial = file.string() + ".partial";
  std::ofstream stream(partial);
  stream << ToJson(evaluation).dump(2) << '\n';
  stream.close();
  std::error_code error;
  if (stream) fs::rename(partial, file, error);
  if (!stream || error) {
    std::error_code ignored;
    fs::remove(partial, ignored);
    throw OutputError(file.string() + ": cannot be written (disk full, permissions?)");
  }
}

std::string FormatTable(std::span<const RunEvaluation> evaluations) {
  std::vector<std::string> names;  // in order of appearance
  std::vector<std::map<std::string, std::string>> columns;
  for (const RunEvaluation& evaluation : evaluations) {
    auto& column = columns.emplace_back();
    for (auto& [name, text] : Rows(evaluation)) {
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
      column[name] = text;
    }
  }
  constexpr std::size_t kNameWidth = 26;
  std::string table = Pad("", kNameWidth, false);
  for (const RunEvaluation& evaluation : evaluations) {
    table += "  " + Pad(ShortName(evaluation.result), 10, true);
  }
  table += '\n';
  for (const std::string& name : names) {
    table += Pad(name, kNameWidth, false);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const std::size_t width = std::max<std::size_t>(10, ShortName(evaluations[c].result).size());
      const auto text = columns[c].find(name);
      table += "  " + Pad(text == columns[c].end() ? "-" : text->second, width, true);
    }
    table += '\n';
  }
  return table;
}

}  // namespace facet
