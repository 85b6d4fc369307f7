// SPDX-License-Identifier: BSD-2-Clause
// The result of a run while it goes on: whenever the program is killed, what is there is valid.
#pragma once

#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "run_sequence.h"

#include "facet/io/partial_folder.h"
#include "facet/io/result_writer.h"
#include "facet/mesh/map_follower.h"
#include "facet/pipeline/vio_output.h"

namespace facet {

/// Writes on a thread of its own. Each line and each file appears as a whole. After at most a tenth
/// of a second the files with a line per frame have what was added, after half a second the others:
/// keyframes.tum, landmarks.ply, mesh.ply, planes.csv, map.ply (without the horizon, which is
/// mesh.ply; less often once writing it takes more than 0.1 s) and summary.json. Where the disk
/// fails a warning says so once, and the run goes on.
class PartialResult {
 public:
  /// `about`: version, sequence, calibration, pipeline, threads and config. Throws ConfigError and
  /// OutputError.
  PartialResult(const std::filesystem::path& target,
                const RunRecord& about,
                const SurfaceMapOptions& map);
  /// Leaves the folder with everything that was added.
  ~PartialResult();
  PartialResult(const PartialResult&) = delete;
  PartialResult& operator=(const PartialResult&) = delete;

  const std::filesystem::path& folder() const { return folder_.path(); }

  /// After each frame, from one thread; returns at once.
  void Add(const RunProgress& progress, const VioOutput& output);

  /// Whether the pipeline should be asked for a scene update (VioPipeline::RequestSceneUpdate).
  bool WantsSceneUpdate();

  /// The whole result is in its place: ends, and removes the folder.
  void Remove();

 private:
  using Clock = std::chrono::steady_clock;

  /// What has come since the thread looked last.
  struct Inbox {
    std::vector<FrameRecord> frames;
    std::vector<StampedPose> finished_keyframes;
    std::shared_ptr<const MapSnapshot> snapshot;
    std::shared_ptr<const MeshSnapshot> mesh;
    std::vector<std::shared_ptr<const SceneUpdate>> scene_updates;
    RunProgress progress;
    int num_resets = 0, num_imu_gaps = 0;
  };

  void Run();
  void TakeInbox();
  void WriteLines(const std::vector<FrameRecord>& frames);
  void WriteRest();
  void WriteKeyframes();
  void WriteMap();
  void WriteSummary();
  void Stop();

  PartialFolder folder_;
  LineFile states_, timing_, trajectory_;
  const Clock::time_point start_ = Clock::now();

  std::mutex mutex_;  // of the inbox and the two flags
  std::condition_variable changed_;
  Inbox inbox_;
  bool is_over_ = false;
  bool has_failed_ = false;
  Clock::time_point last_request_{};  // run's thread only

  // The thread's own from here on.
  RunRecord record_;
  std::shared_ptr<const MapSnapshot> snapshot_, snapshot_written_;
  std::shared_ptr<const MeshSnapshot> mesh_written_, mesh_;
  bool has_new_planes_ = false;
  MapFollower map_;
  std::map<CubeIndex, TriangleMesh> map_parts_;
  Clock::time_point next_map_{};
  std::thread thread_;  // last: it uses the others
};

}  // namespace facet
