// SPDX-License-Identifier: BSD-2-Clause
#include "partial_result.h"

#include <cstdio>
#include <exception>
#include <utility>

#include "process_usage.h"

#include "facet/io/ply_writer.h"
#include "facet/io/text_file.h"
#include "facet/io/trajectory_file.h"
#include "facet/regularities/report/plane_ids.h"

namespace facet {
namespace {

constexpr std::chrono::milliseconds kLinePeriod{100};
constexpr int kLinesPerRest = 5;  // the other files are written with every fifth look
constexpr std::chrono::milliseconds kRequestPeriod{400};
// A map is not written again before five times the time that it has taken.
constexpr int kMapShare = 5;

void Append(const TriangleMesh& part, TriangleMesh& mesh) {
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
  mesh.normals.insert(mesh.normals.end(), part.normals.begin(), part.normals.end());
  mesh.colours.insert(mesh.colours.end(), part.colours.begin(), part.colours.end());
  mesh.plane_ids.insert(mesh.plane_ids.end(), part.plane_ids.begin(), part.plane_ids.end());
  for (const auto& [a, b, c] : part.faces)
    mesh.faces.push_back({first + a, first + b, first + c});
}

}  // namespace

PartialResult::PartialResult(const std::filesystem::path& target,
                             const RunRecord& about,
                             const SurfaceMapOptions& map)
    : folder_(target),
      states_(folder_.path() / PartialFolder::kStates, StatesHeader()),
      timing_(folder_.path() / PartialFolder::kTiming, TimingHeader()),
      trajectory_(folder_.path() / PartialFolder::kTrajectory, TumHeader()),
      record_(about),
      map_(map) {
  record_.is_interrupted = record_.is_realtime = true;
  folder_.Replace(PartialFolder::kConfig,
                  [&](const auto& file) { WriteTextFile(file, about.config); });
  WriteSummary();
  thread_ = std::thread([this] { Run(); });
}

PartialResult::~PartialResult() {
  Stop();
}

void PartialResult::Stop() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void PartialResult::Remove() {
  Stop();
  folder_.Remove();
}

void PartialResult::Add(const RunProgress& progress, const VioOutput& output) {
  const std::lock_guard lock(mutex_);
  if (has_failed_) return;
  inbox_.frames.push_back(*progress.newest);
  inbox_.progress = progress;
  inbox_.progress.newest = nullptr;
  inbox_.num_resets += output.was_reset ? 1 : 0;
  inbox_.num_imu_gaps += output.imu_gaps;
  for (const KeyframePose& keyframe : output.finished_keyframes)
    inbox_.finished_keyframes.push_back({keyframe.t, keyframe.T_WB});
  if (output.snapshot) inbox_.snapshot = output.snapshot;
  if (output.mesh) inbox_.mesh = output.mesh;
  if (output.scene_update) inbox_.scene_updates.push_back(output.scene_update);
}

bool PartialResult::WantsSceneUpdate() {
  const auto now = Clock::now();
  if (now - last_request_ < kRequestPeriod) return false;
  {
    const std::lock_guard lock(mutex_);
    if (has_failed_) return false;
  }
  last_request_ = now;
  return true;
}

void PartialResult::Run() {
  bool is_over = false;
  try {
    for (int i = 1; !is_over; ++i) {
      {
        std::unique_lock lock(mutex_);
        is_over = changed_.wait_for(lock, kLinePeriod, [this] { return is_over_; });
      }
      TakeInbox();
      if (i % kLinesPerRest == 0 || is_over) WriteRest();
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr,
                 "facet: warning: %s; what a kill would leave in %s ends here\n",
                 error.what(),
                 folder_.path().c_str());
    const std::lock_guard lock(mutex_);
    has_failed_ = true;  // nobody takes what would still come
    inbox_ = {};
  }
}

void PartialResult::TakeInbox() {
  Inbox taken;
  {
    const std::lock_guard lock(mutex_);
    std::swap(taken, inbox_);
  }
  if (taken.frames.empty()) return;
  WriteLines(taken.frames);
  record_.frames.insert(record_.frames.end(), taken.frames.begin(), taken.frames.end());
  record_.keyframes.insert(
      record_.keyframes.end(), taken.finished_keyframes.begin(), taken.finished_keyframes.end());
  record_.num_frames = taken.progress.num_frames;
  record_.num_dropped = taken.progress.num_dropped;
  record_.num_damaged = taken.progress.num_damaged;
  record_.first_pair = taken.progress.first_pair;
  record_.num_resets += taken.num_resets;
  record_.num_imu_gaps += taken.num_imu_gaps;
  record_.duration_s = ToSeconds(record_.frames.back().t - record_.first_pair);
  if (taken.snapshot) snapshot_ = taken.snapshot;
  if (taken.mesh) mesh_ = taken.mesh;
  for (const auto& update : taken.scene_updates) {
    map_.Take(update->map_blocks);
    record_.planes = update->planes;
    has_new_planes_ = true;
  }
}

void PartialResult::WriteLines(const std::vector<FrameRecord>& frames) {
  std::string states, timing, trajectory;
  for (const FrameRecord& frame : frames) {
    AppendStatesLine(frame, states);
    AppendTimingLine(frame, timing);
    if (frame.has_pose) trajectory += FormatTumLine({frame.t, frame.state.T_WB});
  }
  states_.Add(states);
  timing_.Add(timing);
  trajectory_.Add(trajectory);
}

void PartialResult::WriteRest() {
  if (snapshot_ != snapshot_written_) {
    WriteKeyframes();
    snapshot_written_ = snapshot_;
  }
  if (mesh_ != mesh_written_) {
    folder_.Replace("mesh.ply",
                    [&](const auto& file) { WritePlyMesh(file, MeshWithSigmas(*mesh_)); });
    mesh_written_ = mesh_;
  }
  if (std::exchange(has_new_planes_, false)) {
    folder_.Replace("planes.csv",
                    [&](const auto& file) { WriteTextFile(file, PlanesCsv(*record_.planes)); });
  }
  WriteMap();
  WriteSummary();
}

// Those that have left the window, which need not be the oldest ones first, are final; those in it
// are as the newest keyframe says.
void PartialResult::WriteKeyframes() {
  std::vector<StampedPose> poses = record_.keyframes;
  for (const KeyframePose& keyframe : snapshot_->keyframes)
    poses.push_back({keyframe.t, keyframe.T_WB});
  SortByTime(poses);
  folder_.Replace("keyframes.tum", [&](const auto& file) { WriteTum(file, poses); });
  std::vector<Vector3d> landmarks;
  for (const LandmarkEstimate& landmark : snapshot_->landmarks)
    landmarks.push_back(landmark.p_W);
  folder_.Replace("landmarks.ply", [&](const auto& file) { WritePlyPoints(file, landmarks); });
}

void PartialResult::WriteMap() {
  const auto begin = Clock::now();
  if (!map_.has_changed() || begin < next_map_) return;
  while (auto part = map_.TakePart())
    map_parts_[part->index] = std::move(part->mesh);
  TriangleMesh mesh;
  for (const auto& [index, part] : map_parts_)
    Append(part, mesh);
  if (record_.planes) UseCurrentPlaneIds(*record_.planes, mesh.plane_ids);
  folder_.Replace("map.ply", [&](const auto& file) { WritePlyMesh(file, mesh); });
  const auto end = Clock::now();
  next_map_ = end + kMapShare * (end - begin);
}

void PartialResult::WriteSummary() {
  record_.wall_s = std::chrono::duration<double>(Clock::now() - start_).count();
  record_.cpu_s = ProcessCpuSeconds();
  record_.peak_rss_mb = PeakRssMb();
  folder_.Replace(PartialFolder::kSummary,
                  [&](const auto& file) { WriteTextFile(file, SummaryJson(record_)); });
}

}  // namespace facet
