// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/result_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include <nlohmann/json.hpp>

#include "facet/io/calibration_writer.h"
#include "facet/io/errors.h"
#include "facet/io/json_file.h"
#include "facet/io/loop_files.h"
#include "facet/io/ply_writer.h"
#include "facet/io/text_file.h"
#include "facet/io/vertex_sigmas.h"

namespace facet {
namespace {

using Json = nlohmann::ordered_json;

// ---------------------------------------------------------------------------------------- csv

void AppendNumber(std::string& line, double value, const char* format = ",%.12g") {
  char text[40];
  std::snprintf(text, sizeof(text), format, value);
  line += text;
}

void AppendText(std::string& line, const std::string& field) {
  line += ',';
  line += field;
}

void AppendVector(std::string& line, const Vector3d& v) {
  for (int i = 0; i < 3; ++i)
    AppendNumber(line, v[i]);
}

std::string Quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (char c : text)
    quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

double TotalWithoutDecode(const StageTimes& times) {
  return times.Total() - times[Stage::kDecode];
}

template <class AppendLine>
std::string Table(std::string header,
                  const std::vector<FrameRecord>& frames,
                  const AppendLine& append_line) {
  for (const FrameRecord& frame : frames)
    append_line(frame, header);
  return header;
}

// ------------------------------------------------------------------------------------- summary

double Median(std::vector<double> values) {
  const std::size_t n = values.size();
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

/// Smallest value that at least the given share of all values does not exceed.
double Percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

Json StageSummary(const std::vector<FrameRecord>& frames,
                  const std::function<double(const StageTimes&)>& stage) {
  std::vector<double> all, keyframes;
  double sum = 0;
  for (const FrameRecord& f : frames) {
    all.push_back(stage(f.times));
    sum += all.back();
    if (f.is_keyframe) keyframes.push_back(all.back());
  }
  Json json = {{"mean_ms", sum / static_cast<double>(all.size())},
               {"median_ms", Median(all)},
               {"p99_ms", Percentile(all, 0.99)},
               {"max_ms", *std::max_element(all.begin(), all.end())}};
  if (!keyframes.empty()) json["keyframe_median_ms"] = Median(keyframes);
  return json;
}

/// Stages that never ran are absent.
Json StagesSummary(const std::vector<FrameRecord>& frames) {
  Json stages = Json::object();
  for (std::size_t i = 0; i < kNumStages; ++i) {
    const bool ran = std::any_of(
        frames.begin(), frames.end(), [i](const FrameRecord& f) { return f.times.ms[i] > 0; });
    if (ran)
      stages[kStageNames[i]] = StageSummary(frames, [i](const StageTimes& t) { return t.ms[i]; });
  }
  if (!frames.empty()) {
    stages["total_without_decode"] = StageSummary(frames, TotalWithoutDecode);
    stages["total"] = StageSummary(frames, [](const StageTimes& t) { return t.Total(); });
  }
  return stages;
}

std::optional<LatencyFigures> FiguresOf(const std::vector<double>& latencies_ms) {
  if (latencies_ms.empty()) return std::nullopt;
  return LatencyFigures{Median(latencies_ms),
                        Percentile(latencies_ms, 0.9),
                        Percentile(latencies_ms, 0.99),
                        *std::ranges::max_element(latencies_ms)};
}

Json LatencySummary(const std::vector<FrameRecord>& frames) {
  Json json = Json::object();
  const auto add = [&](const char* name, const std::optional<LatencyFigures>& figures) {
    if (!figures) return;
    json[name] = {{"median_ms", figures->median_ms},
                  {"p90_ms", figures->p90_ms},
                  {"p99_ms", figures->p99_ms},
                  {"max_ms", figures->max_ms}};
  };
  add("pose", PoseLatency(frames));
  add("mesh", MeshLatency(frames));
  return json;
}

// From when to when each of them has poses.
Json SegmentsSummary(const std::vector<FrameRecord>& frames) {
  Json segments = Json::array();
  for (const FrameRecord& f : frames) {
    if (!f.has_pose) continue;
    if (segments.empty() || segments.back()["segment"] != f.segment) {
      segments.push_back(
          {{"segment", f.segment}, {"first_ns", f.t.ns}, {"last_ns", 0}, {"frames_with_pose", 0}});
    }
    segments.back()["last_ns"] = f.t.ns;
    segments.back()["frames_with_pose"] = segments.back()["frames_with_pose"].get<int>() + 1;
  }
  return segments;
}

Json Summary(const RunRecord& run) {
  const auto& frames = run.frames;
  std::vector<double> landmarks;
  for (const FrameRecord& f : frames) {
    if (f.has_pose) landmarks.push_back(f.num_landmarks);
  }
  Json json;
  json["version"] = run.version;
  json["sequence"] = run.sequence;
  json["pipeline"] = run.pipeline;
  json["threads"] = run.threads;
  json["calibration"] = run.calibration;
  json["frames"] = run.num_frames;
  json["frames_with_pose"] = landmarks.size();
  json["keyframes"] = run.keyframes.size();
  json["duration_s"] = run.duration_s;
  json["wall_s"] = run.wall_s;
  json["cpu_s"] = run.cpu_s;
  if (run.wall_s > 0) json["realtime_factor"] = run.duration_s / run.wall_s;
  json["peak_rss_mb"] = run.peak_rss_mb;
  if (run.is_interrupted) {
    json["interrupted"] = true;
  } else {
    json["stages"] = StagesSummary(frames);
  }
  if (run.is_realtime) json["latency"] = LatencySummary(frames);
  if (const auto init_s = run.InitSeconds()) json["init_s"] = *init_s;
  if (!landmarks.empty()) json["landmarks_median"] = Median(landmarks);
  json["planes_total"] = run.planes ? run.planes->size() : 0;
  const auto most = [&](int FrameRecord::*count) {
    int out = 0;
    for (const FrameRecord& f : frames)
      out = std::max(out, f.*count);
    return out;
  };
  json["planes_max_active"] = most(&FrameRecord::num_planes);
  json["constraints_max"] = most(&FrameRecord::num_constraints);
  if (run.mesh) json["mesh_faces"] = run.mesh->faces.size();
  if (!run.mesh_areas_m2.empty()) {
    json["mesh_area_m2_median"] = Median(run.mesh_areas_m2);
    json["view_mesh_area_m2_median"] = Median(run.view_areas_m2);
  }
  if (run.map) {
    json["map_faces"] = run.map->faces.size();
    json["map_vertices"] = run.map->vertices.size();
    json["map_memory_mb"] = run.map_memory_mb;
    json["map_is_full"] = run.map_is_full;
  }
  if (run.loops) {
    json["loops"] = {{"places", run.loops->num_places},
                     {"compared", run.loops->closures.size()},
                     {"closures", run.loops->NumAccepted()},
                     {"memory_mb", run.loops->memory_mb},
                     {"cpu_s", 1e-3 * run.loops->cpu_ms}};
    if (run.loops->has_known_map) {
      auto& known = json["loops"]["known_map"];
      known["places"] = run.loops->num_known_places;
      known["localised_s"] = nullptr;
      if (run.loops->localised && !frames.empty())
        known["localised_s"] = ToSeconds(*run.loops->localised - frames.front().t);
      known["ambiguous"] = run.loops->is_ambiguous;
    }
  }
  json["resets"] = run.num_resets;
  json["segments"] = SegmentsSummary(frames);
  json["dropped_frames"] = run.num_dropped;
  json["damaged_frames"] = run.num_damaged;
  json["imu_gaps"] = run.num_imu_gaps;
  json["warnings"] = run.warnings;
  return json;
}

}  // namespace

std::vector<StampedPose> RunRecord::CausalTrajectory() const {
  std::vector<StampedPose> poses;
  for (const FrameRecord& f : frames) {
    if (f.has_pose) poses.push_back({f.t, f.state.T_WB});
  }
  return poses;
}

std::vector<StampedPose> RunRecord::CausalMapTrajectory() const {
  std::vector<StampedPose> poses;
  for (const FrameRecord& f : frames) {
    if (f.has_pose && f.is_in_map) poses.push_back({f.t, f.T_MW * f.state.T_WB});
  }
  return poses;
}

std::optional<double> RunRecord::InitSeconds() const {
  const auto first =
      std::find_if(frames.begin(), frames.end(), [](const FrameRecord& f) { return f.has_pose; });
  if (first == frames.end()) return std::nullopt;
  return ToSeconds(first->t - first_pair);
}

std::string StatesHeader() {
  return "timestamp_ns,px,py,pz,qw,qx,qy,qz,vx,vy,vz,bgx,bgy,bgz,bax,bay,baz,"
         "sigma_px,sigma_py,sigma_pz,sigma_rx,sigma_ry,sigma_rz,sigma_vx,sigma_vy,sigma_vz,"
         "sigma_bgx,sigma_bgy,sigma_bgz,sigma_bax,sigma_bay,sigma_baz,"
         "status,reason,segment\n";
}

void AppendStatesLine(const FrameRecord& f, std::string& text) {
  constexpr int kNumValues = 31;
  text += std::to_string(f.t.ns);
  if (f.has_pose) {
    const Quaterniond& q = f.state.T_WB.q;
    AppendVector(text, f.state.T_WB.p);
    for (double component : {q.w(), q.x(), q.y(), q.z()})
      AppendNumber(text, component);
    for (const Vector3d& v : {f.state.v_WB,
                              f.state.bias.b_g,
                              f.state.bias.b_a,
                              f.sigma_p,
                              f.sigma_theta,
                              f.sigma_v,
                              f.sigma_b_g,
                              f.sigma_b_a}) {
      AppendVector(text, v);
    }
  } else {
    text.append(kNumValues, ',');
  }
  AppendText(text, Quoted(f.status));
  AppendText(text, Quoted(f.reason));
  AppendText(text, f.has_pose ? std::to_string(f.segment) : "");
  text += '\n';
}

std::string TimingHeader() {
  std::string text = "timestamp_ns,is_keyframe";
  for (const char* name : kStageNames)
    text += std::string(",") + name;
  return text +
         ",total_without_decode,total,wall_ms,latency_ms,landmarks,planes,constraints,"
         "pose_latency_ms\n";
}

void AppendTimingLine(const FrameRecord& f, std::string& text) {
  text += std::to_string(f.t.ns) + (f.is_keyframe ? ",1" : ",0");
  for (double ms : f.times.ms)
    AppendNumber(text, ms, ",%.4f");
  for (double ms : {TotalWithoutDecode(f.times), f.times.Total(), f.wall_ms, f.latency_ms}) {
    AppendNumber(text, ms, ",%.4f");
  }
  for (int count : {f.num_landmarks, f.num_planes, f.num_constraints}) {
    AppendText(text, std::to_string(count));
  }
  AppendNumber(text, f.pose_latency_ms, ",%.4f");
  text += '\n';
}

// `outline` holds its corners, "x y z" apart by semicolons; `absorbed` the ids of planes that
// turned out to be this one, apart by blanks: meshes that were written on the way have them.
std::string PlanesCsv(const std::vector<PlaneRecord>& planes) {
  std::string text =
      "id,nx,ny,nz,d,cx,cy,cz,orientation,label,first_seen_ns,last_seen_ns,landmarks,area_m2,"
      "sigma_normal_rad,sigma_d_m,outline,absorbed\n";
  for (const PlaneRecord& plane : planes) {
    text += std::to_string(plane.id.value);
    AppendVector(text, plane.plane_W.n);
    AppendNumber(text, plane.plane_W.d);
    AppendVector(text, plane.centroid_W);
    AppendText(text, ToString(plane.orientation));
    AppendText(text, ToString(plane.label));
    AppendText(text, std::to_string(plane.first_seen.ns));
    AppendText(text, std::to_string(plane.last_seen.ns));
    AppendText(text, std::to_string(plane.num_landmarks));
    for (double value : {plane.area_m2, plane.sigma_normal_rad, plane.sigma_d_m})
      AppendNumber(text, value, ",%.6g");
    text += ',';
    for (std::size_t k = 0; k < plane.outline_W.size(); ++k) {
      const Vector3d& p = plane.outline_W[k];
      char corner[100];
      std::snprintf(
          corner, sizeof(corner), "%s%.3f %.3f %.3f", k == 0 ? "" : ";", p.x(), p.y(), p.z());
      text += corner;
    }
    text += ',';
    for (std::size_t k = 0; k < plane.merged_ids.size(); ++k)
      text += (k == 0 ? "" : " ") + std::to_string(plane.merged_ids[k].value);
    text += '\n';
  }
  return text;
}

std::string SummaryJson(const RunRecord& run) {
  return JsonText(Summary(run), 2) + "\n";
}

std::optional<LatencyFigures> PoseLatency(const std::vector<FrameRecord>& frames) {
  std::vector<double> all;
  for (const FrameRecord& f : frames) {
    if (f.has_pose) all.push_back(f.pose_latency_ms);
  }
  return FiguresOf(all);
}

std::optional<LatencyFigures> MeshLatency(const std::vector<FrameRecord>& frames) {
  std::vector<double> all;
  for (const FrameRecord& f : frames) {
    if (f.has_pose && f.is_keyframe) all.push_back(f.latency_ms);
  }
  return FiguresOf(all);
}

std::vector<OdometryPose> OdometryOf(const RunRecord& run) {
  std::vector<OdometryPose> poses;
  for (const FrameRecord& f : run.frames) {
    if (f.has_pose) poses.push_back({{f.t, f.state.T_WB}, f.segment});
  }
  return poses;
}

void WriteResult(const std::filesystem::path& folder, const RunRecord& run) {
  WriteTum(folder / "trajectory.tum", run.CausalTrajectory());
  WriteTum(folder / "keyframes.tum", run.keyframes);
  WriteTextFile(folder / "states.csv", Table(StatesHeader(), run.frames, AppendStatesLine));
  WriteTextFile(folder / "timing.csv", Table(TimingHeader(), run.frames, AppendTimingLine));
  WritePlyPoints(folder / "landmarks.ply", run.landmarks);
  if (run.mesh) {
    WritePlyMesh(folder / "mesh.ply", *run.mesh);
    WriteVertexSigmas(folder / "mesh.ply", run.mesh->sigma_m);
  }
  if (run.map) WritePlyMesh(folder / "map.ply", *run.map);
  if (run.planes) WriteTextFile(folder / "planes.csv", PlanesCsv(*run.planes));
  if (run.loops) {
    WriteTum(folder / "trajectory_map.tum", run.CausalMapTrajectory());
    WriteTum(folder / "trajectory_final.tum", MoveIntoMap(OdometryOf(run), run.loops->corrections));
    WriteTextFile(folder / "closures.csv", ClosuresCsv(run.loops->closures));
  }
  if (run.estimated_calibration)
    WriteCalibration(folder / "calibration.yaml", *run.estimated_calibration);
  WriteTextFile(folder / "config.yaml", run.config);
  WriteTextFile(folder / "summary.json", SummaryJson(run));
}

}  // namespace facet
