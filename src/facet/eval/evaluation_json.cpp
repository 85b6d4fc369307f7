// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/evaluation_json.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <map>
#include <numbers>
#include <set>

#include <nlohmann/json.hpp>

namespace facet {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

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

ordered_json ToJson(const DistanceStatistics& s) {
  return {{"accuracy_mean_m", s.mean_m},
          {"accuracy_median_m", s.median_m},
          {"accuracy_p90_m", s.p90_m},
          {"accuracy_rmse_m", s.rmse_m}};
}

ordered_json ToJson(const NearFigures& figures) {
  ordered_json json = {{"accuracy_median_m", figures.median_m},
                       {"precision_5cm", figures.precision}};
  if (figures.completeness) {
    json["completeness_5cm"] = *figures.completeness;
    json["fscore_5cm"] = *figures.fscore;
  }
  json["samples"] = figures.num_samples;
  return json;
}

ordered_json ToJson(const MeshFigures& figures) {
  ordered_json json = ToJson(figures.accuracy);
  json["precision_5cm"] = figures.precision[0];
  json["precision_10cm"] = figures.precision[1];
  if (figures.completeness) {
    json["completeness_5cm"] = (*figures.completeness)[0];
    json["completeness_10cm"] = (*figures.completeness)[1];
    json["completeness_20cm"] = (*figures.completeness)[2];
  }
  if (figures.fscore) {
    json["fscore_5cm"] = (*figures.fscore)[0];
    json["fscore_10cm"] = (*figures.fscore)[1];
  }
  if (figures.near) json["within_3m"] = ToJson(*figures.near);
  for (const RangeBin& bin : figures.by_range) {
    ordered_json entry = {{"from_m", bin.from_m}, {"to_m", bin.to_m}, {"samples", bin.num_samples}};
    entry.update(ToJson(bin.accuracy));
    json["by_range"].push_back(entry);
  }
  return json;
}

ordered_json ToJson(const MeshError& error) {
  ordered_json json = ToJson(error.aligned);
  json["area_m2"] = error.area_m2;
  json["files"] = error.num_files;
  json["vertices"] = error.num_vertices;
  json["faces"] = error.num_faces;
  json["samples"] = error.num_samples;
  json["truth_points_seen"] = error.num_seen;
  if (error.doubled_area) json["doubled_area"] = *error.doubled_area;
  if (error.plane_areas) {
    json["plane_areas"] = {{"rmse_m", error.plane_areas->rmse_m},
                           {"left_out", error.plane_areas->left_out},
                           {"samples", error.plane_areas->num_samples}};
  }
  json["icp"] = ToJson(error.icp.figures);
  json["icp"]["correction_translation_m"] = error.icp.correction_translation_m;
  json["icp"]["correction_rotation_deg"] = error.icp.correction_rotation_deg;
  json["icp"]["suspicious"] = error.icp.is_suspicious;
  return json;
}

ordered_json ToJson(const PlaneError& error) {
  ordered_json json = ordered_json::object();
  if (error.recall) json["recall"] = *error.recall;
  if (error.precision) json["precision"] = *error.precision;
  if (error.normal_error_deg_median)
    json["normal_error_deg_median"] = *error.normal_error_deg_median;
  if (error.offset_error_m_median) json["offset_error_m_median"] = *error.offset_error_m_median;
  json["duplicates"] = error.num_duplicates;
  json["matched"] = error.num_matched;
  json["estimated"] = error.num_estimated;
  json["truth"] = error.num_true;
  return json;
}

ordered_json ToJson(const NormalizedErrors& errors, const char* rmse) {
  ordered_json json;
  if (errors.num_states > 0) {
    json["nees"] = errors.nees;
    json["nees_median"] = errors.nees_median;
    json["within_2_sigma"] = errors.within_two_sigma;
    json["states"] = errors.num_states;
  }
  json[rmse] = errors.rmse;
  return json;
}

ordered_json ToJson(const ConsistencyError& error) {
  ordered_json json = ordered_json::object();
  if (error.position) json["position"] = ToJson(*error.position, "rmse_m");
  if (error.orientation) json["orientation"] = ToJson(*error.orientation, "rmse_rad");
  if (error.velocity) json["velocity"] = ToJson(*error.velocity, "rmse_m_per_s");
  if (error.gyro_bias) json["gyro_bias"] = ToJson(*error.gyro_bias, "rmse_rad_per_s");
  if (error.accel_bias) json["accelerometer_bias"] = ToJson(*error.accel_bias, "rmse_m_per_s2");
  return json;
}

ordered_json ToJson(const CalibrationError& e) {
  ordered_json json;
  json["disparity_mean_px"] = e.disparity_mean_px;
  json["disparity_rms_px"] = e.disparity_rms_px;
  json["vertical_rms_px"] = e.vertical_rms_px;
  json["time_offset_ms"] = 1e3 * e.error(kTimeOffset);
  if (e.nees) json["nees"] = *e.nees;
  for (int i = 0; i < kNumCalibration; ++i)
    json["errors"][kCalibrationNames[static_cast<std::size_t>(i)]] = e.error(i);
  return json;
}

std::string Text(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

// Rows of the table in order: name and the text of one run.
using Rows = std::vector<std::pair<std::string, std::string>>;

void AddNearRows(const std::string& name, const NearFigures& near, Rows& rows) {
  rows.emplace_back(name + " within 3 m, median [m]", Text("%.4f", near.median_m));
  if (!near.fscore) return;
  rows.emplace_back(name + " within 3 m, F 5 cm [%]", Text("%.1f", 100 * *near.fscore));
}

void AddMeshRows(const std::string& name, const MeshError& error, Rows& rows) {
  const MeshFigures& aligned = error.aligned;
  rows.emplace_back(name + " accuracy mean [m]", Text("%.4f", aligned.accuracy.mean_m));
  rows.emplace_back(name + " accuracy median [m]", Text("%.4f", aligned.accuracy.median_m));
  rows.emplace_back(name + " accuracy p90 [m]", Text("%.4f", aligned.accuracy.p90_m));
  rows.emplace_back(name + " area within 5 cm [%]", Text("%.1f", 100 * aligned.precision[0]));
  if (aligned.near) AddNearRows(name, *aligned.near, rows);
  for (const RangeBin& bin : aligned.by_range) {
    rows.emplace_back(name + " mean, " + Text("%g", bin.from_m) + "-" + Text("%g m [m]", bin.to_m),
                      Text("%.4f", bin.accuracy.mean_m));
  }
  if (aligned.completeness) {
    rows.emplace_back(name + " complete 10 cm [%]", Text("%.1f", 100 * (*aligned.completeness)[1]));
    rows.emplace_back(name + " F-score 10 cm [%]", Text("%.1f", 100 * (*aligned.fscore)[1]));
  }
  if (error.plane_areas)
    rows.emplace_back(name + " on planes, rmse [m]", Text("%.4f", error.plane_areas->rmse_m));
  rows.emplace_back(name + " mean after ICP [m]", Text("%.4f", error.icp.figures.accuracy.mean_m));
  rows.emplace_back(name + " ICP correction [m]", Text("%.4f", error.icp.correction_translation_m));
  rows.emplace_back(name + " ICP correction [deg]",
                    Text("%.3f", error.icp.correction_rotation_deg));
  rows.emplace_back(name + " area [m2]", Text("%.1f", error.area_m2));
  if (error.doubled_area) {
    rows.emplace_back(name + " doubled area [%]", Text("%.2f", 100 * *error.doubled_area));
  }
}

void AddShares(const PlaneError& error, const std::string& limits, Rows& rows) {
  const auto add = [&](const char* name, const std::optional<double>& share) {
    if (share) rows.emplace_back(name + limits + " [%]", Text("%.1f", 100 * *share));
  };
  add("planes recall", error.recall);
  add("planes precision", error.precision);
}

void AddPlaneRows(const RunEvaluation& e, Rows& rows) {
  if (!e.planes) return;
  const PlaneError& error = *e.planes;
  AddShares(error, "", rows);
  if (e.close_planes) AddShares(*e.close_planes, ", 3 deg 5 cm", rows);
  if (e.close_planes_by_distance) AddShares(*e.close_planes_by_distance, ", 3 deg 2 %", rows);
  if (error.normal_error_deg_median) {
    rows.emplace_back("planes normal, median [deg]", Text("%.2f", *error.normal_error_deg_median));
    rows.emplace_back("planes offset, median [m]", Text("%.4f", *error.offset_error_m_median));
  }
  rows.emplace_back("planes duplicates", std::to_string(error.num_duplicates));
}

void AddConsistencyRows(const ConsistencyError& error, Rows& rows) {
  const auto add = [&rows](const char* name, const std::optional<NormalizedErrors>& errors) {
    if (errors && errors->num_states > 0) {
      rows.emplace_back(std::string("NEES ") + name, Text("%.2f", errors->nees));
    }
  };
  add("position", error.position);
  add("orientation", error.orientation);
  add("velocity", error.velocity);
  add("gyro bias", error.gyro_bias);
  add("accelerometer bias", error.accel_bias);
}

void AddCalibrationRows(const CalibrationError& e, Rows& rows) {
  rows.emplace_back("calibration: disparity at infinity [px]", Text("%+.3f", e.disparity_mean_px));
  rows.emplace_back("calibration: the same, rms [px]", Text("%.3f", e.disparity_rms_px));
  rows.emplace_back("calibration: across the rows, rms [px]", Text("%.3f", e.vertical_rms_px));
  rows.emplace_back("calibration: time offset [ms]", Text("%+.3f", 1e3 * e.error(kTimeOffset)));
  if (e.nees) rows.emplace_back("NEES calibration", Text("%.2f", *e.nees));
}

Rows RowsOf(const RunEvaluation& e) {
  Rows rows;
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
  for (const SegmentError& s : e.segments) {
    rows.emplace_back("ATE rmse, segment " + std::to_string(s.segment) + " [m]",
                      Text("%.4f", s.error.ate_m.rmse));
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
  if (e.time_offset) rows.emplace_back("time offset [s]", Text("%+.6f", ToSeconds(*e.time_offset)));
  if (e.mesh) AddMeshRows("mesh", *e.mesh, rows);
  if (e.map) AddMeshRows("map", *e.map, rows);
  AddPlaneRows(e, rows);
  if (e.consistency) AddConsistencyRows(*e.consistency, rows);
  if (e.calibration) AddCalibrationRows(*e.calibration, rows);
  return rows;
}

// The last `count` names of a path.
std::string Tail(const fs::path& path, std::ptrdiff_t count) {
  const std::ptrdiff_t length = std::distance(path.begin(), path.end());
  fs::path tail;
  for (auto it = std::next(path.begin(), std::max<std::ptrdiff_t>(0, length - count));
       it != path.end();
       ++it)
    tail /= *it;
  return tail.string();
}

std::string Pad(const std::string& text, std::size_t width, bool right) {
  const std::string blanks(text.size() < width ? width - text.size() : 0, ' ');
  return right ? blanks + text : text + blanks;
}

}  // namespace

nlohmann::ordered_json ToJson(const RunEvaluation& e) {
  ordered_json json;
  if (e.coverage) json["coverage"] = *e.coverage;
  json["poses_with_truth"] = e.causal.num_pairs;
  json["poses_without_truth"] = e.causal.num_outside + e.causal.num_in_gaps;
  json["path_length_m"] = e.causal.path_length_m;
  json["alignment"] = ToJson(e.causal.alignment, e.alignment);
  if (e.time_offset) json["time_offset_s"] = ToSeconds(*e.time_offset);
  json["ate"] = ToJson(e.causal.ate_m);
  if (e.keyframes) json["ate_keyframes"] = ToJson(e.keyframes->ate_m);
  if (!e.segments.empty()) {
    json["segments"] = ordered_json::array();
    for (const SegmentError& s : e.segments) {
      json["segments"].push_back({{"segment", s.segment},
                                  {"poses_with_truth", s.error.num_pairs},
                                  {"path_length_m", s.error.path_length_m},
                                  {"ate", ToJson(s.error.ate_m)}});
    }
  }
  json["rpe"] = ordered_json::array();
  for (const RelativeErrors& errors : e.causal.rpe) {
    json["rpe"].push_back(ToJson(errors));
  }
  if (e.causal.drift_percent) json["drift_percent"] = *e.causal.drift_percent;
  if (e.causal.scale_error_percent) json["scale_error_percent"] = *e.causal.scale_error_percent;
  if (e.mesh) json["mesh"] = ToJson(*e.mesh);
  if (e.map) json["map"] = ToJson(*e.map);
  if (e.planes) {
    json["planes"] = ToJson(*e.planes);
    if (e.close_planes) json["planes"]["within_3deg_5cm"] = ToJson(*e.close_planes);
    if (e.close_planes_by_distance)
      json["planes"]["within_3deg_2percent"] = ToJson(*e.close_planes_by_distance);
  }
  if (e.consistency) json["consistency"] = ToJson(*e.consistency);
  if (e.calibration) json["calibration"] = ToJson(*e.calibration);
  json["warnings"] = e.warnings;
  return json;
}

std::vector<std::string> ColumnNames(std::span<const RunEvaluation> evaluations) {
  std::vector<fs::path> paths;
  std::ptrdiff_t longest = 1;
  for (const RunEvaluation& evaluation : evaluations) {
    const fs::path clean = fs::absolute(evaluation.result).lexically_normal();
    paths.push_back(clean.has_filename() ? clean : clean.parent_path());
    longest = std::max(longest, std::distance(paths.back().begin(), paths.back().end()));
  }
  const std::size_t num_different = std::set(paths.begin(), paths.end()).size();
  std::vector<std::string> names;
  for (std::ptrdiff_t count = 1; count <= longest; ++count) {
    names.clear();
    for (const fs::path& path : paths)
      names.push_back(Tail(path, count));
    if (std::set(names.begin(), names.end()).size() == num_different) break;
  }
  return names;
}

std::string FormatTable(std::span<const RunEvaluation> evaluations) {
  std::vector<std::string> names;  // in order of appearance
  std::vector<std::map<std::string, std::string>> columns;
  for (const RunEvaluation& evaluation : evaluations) {
    auto& column = columns.emplace_back();
    for (auto& [name, text] : RowsOf(evaluation)) {
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
      column[name] = text;
    }
  }
  constexpr std::size_t kNameWidth = 30;
  std::string table = Pad("", kNameWidth, false);
  const std::vector<std::string> headers = ColumnNames(evaluations);
  for (const std::string& header : headers)
    table += "  " + Pad(header, 10, true);
  table += '\n';
  for (const std::string& name : names) {
    table += Pad(name, kNameWidth, false);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const std::size_t width = std::max<std::size_t>(10, headers[c].size());
      const auto text = columns[c].find(name);
      table += "  " + Pad(text == columns[c].end() ? "-" : text->second, width, true);
    }
    table += '\n';
  }
  return table;
}

}  // namespace facet
