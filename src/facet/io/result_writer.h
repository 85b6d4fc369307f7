// SPDX-License-Identifier: BSD-2-Clause
// The files of a result folder (CONTRACT: `facet run`), from plain records of a run.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "facet/base/stage_timer.h"
#include "facet/camera/stereo_rig.h"
#include "facet/imu/imu_types.h"
#include "facet/io/trajectory_file.h"
#include "facet/loop/loop_result.h"
#include "facet/map/plane_record.h"
#include "facet/mesh/triangle_mesh.h"

namespace facet {

/// What is kept of one stereo frame.
struct FrameRecord {
  Timestamp t;  ///< of the left image
  bool is_keyframe = false;
  bool has_pose = false;
  int segment = 0;        ///< of the pose: the stretches between losses, from 0 on
  NavState state;         ///< causal; meaningless without a pose
  SE3 T_MW;               ///< to the map, as known then
  bool is_in_map = true;  ///< whether it was
  Vector3d sigma_p = Vector3d::Zero();
  Vector3d sigma_theta = Vector3d::Zero();
  Vector3d sigma_v = Vector3d::Zero();
  Vector3d sigma_b_g = Vector3d::Zero();
  Vector3d sigma_b_a = Vector3d::Zero();
  std::string status;  ///< initialising, ok, degraded, lost
  std::string reason;  ///< why it is not ok
  StageTimes times;
  double wall_ms = 0;          ///< decoding and processing
  double latency_ms = 0;       ///< from the arrival of the images to the result, mesh included
  double pose_latency_ms = 0;  ///< from the arrival of the images to the pose
  int num_landmarks = 0;
  int num_planes = 0;
  int num_constraints = 0;  ///< landmarks that lie on planes, once per plane
};

/// A whole run.
struct RunRecord {
  std::string version, sequence, pipeline;
  std::string calibration;  ///< which files and which convention were read
  int threads = 1;
  bool is_realtime = false;  ///< at recorded speed: latencies mean something
  /// The run goes on, or was killed: the summary says so, and has no statistics of the stages.
  bool is_interrupted = false;
  Timestamp first_pair;  ///< first stereo pair after --start
  int num_frames =
      0;  ///< stereo frames of the chosen part, also those that were dropped or damaged
  int num_dropped = 0;  ///< arrived while busy (--realtime)
  int num_damaged = 0;  ///< left image unreadable
  int num_resets = 0;
  int num_imu_gaps = 0;
  double duration_s = 0, wall_s = 0, cpu_s = 0, peak_rss_mb = 0;
  std::vector<std::string> warnings;
  std::vector<FrameRecord> frames;     ///< processed frames in order of time
  std::vector<StampedPose> keyframes;  ///< smoothed, in order of time
  std::vector<Vector3d> landmarks;     ///< of the horizon at the end, in W
  std::optional<TriangleMesh> mesh;    ///< of the horizon at the end, in W
  std::optional<TriangleMesh> map;     ///< of the whole run, in W
  double map_memory_mb = 0;
  bool map_is_full = false;                        ///< it reached its limit, surfaces are missing
  std::optional<std::vector<PlaneRecord>> planes;  ///< ever in the estimator, in W; if looked for
  /// Surface of the horizon mesh and of the newest keyframe's own faces, by keyframe [m^2].
  std::vector<double> mesh_areas_m2, view_areas_m2;
  std::optional<LoopResult> loops;                 ///< if places were looked for
  std::optional<StereoRig> estimated_calibration;  ///< if it was estimated
  std::string config;                              ///< YAML of every parameter in force

  std::vector<StampedPose> CausalTrajectory() const;  ///< of the frames with a pose
  /// The same in the map, corrected as far as was known at each frame.
  std::vector<StampedPose> CausalMapTrajectory() const;
  /// Seconds from first_pair to the first pose.
  std::optional<double> InitSeconds() const;
};

/// Writes trajectory.tum, keyframes.tum, states.csv, timing.csv, landmarks.ply, summary.json,
/// planes.csv, config.yaml and, where there are some, calibration.yaml, mesh.ply and map.ply into
/// an existing folder. Everything but timing.csv and summary.json depends on the estimates alone.
/// Throws OutputError naming the file that could not be written completely.
void WriteResult(const std::filesystem::path& folder, const RunRecord& run);

// The same files part by part, for whoever writes them while the run goes on. Lines have their line
// ends; the headers are the first lines of states.csv and timing.csv.
std::string StatesHeader();
std::string TimingHeader();
void AppendStatesLine(const FrameRecord& frame, std::string& text);
void AppendTimingLine(const FrameRecord& frame, std::string& text);
std::string PlanesCsv(const std::vector<PlaneRecord>& planes);
std::string SummaryJson(const RunRecord& run);

/// Spread of the latencies of a run.
struct LatencyFigures {
  double median_ms = 0, p90_ms = 0, p99_ms = 0, max_ms = 0;
};

/// From the arrival of the images to the pose of each frame; empty without frames.
std::optional<LatencyFigures> PoseLatency(const std::vector<FrameRecord>& frames);

/// From the arrival of the images of each keyframe to its mesh.
std::optional<LatencyFigures> MeshLatency(const std::vector<FrameRecord>& frames);

}  // namespace facet
