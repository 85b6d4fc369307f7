// SPDX-License-Identifier: BSD-2-Clause
// `facet run`: from a recording to a result folder.
#include "run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "align_stereo.h"
#include "interrupts.h"
#include "load_options.h"
#include "partial_result.h"
#include "progress_bar.h"
#include "recorded_images.h"
#include "run_publishing.h"
#include "run_recorder.h"
#include "run_sequence.h"
#include "view.h"

#include "facet/estimator/window/imu_link.h"
#include "facet/eval/ground_truth.h"
#include "facet/io/errors.h"
#include "facet/io/glb_writer.h"
#include "facet/io/ply_writer.h"
#include "facet/io/result_folder.h"
#include "facet/io/result_writer.h"
#include "facet/io/saved_map_file.h"
#include "facet/io/vertex_sigmas.h"
#include "facet/pipeline/threaded_vio.h"
#include "facet/pipeline/vio_pipeline.h"
#include "facet/recording/open_recording.h"
#include "facet/viewer/live_view.h"
#include "facet/viewer/view_access.h"

namespace facet {
namespace {

void Tell(const RunArguments& arguments, const char* kind, const std::string& text) {
  if (arguments.on_message) return arguments.on_message(text);
  std::fprintf(stderr, "facet: %s: %s\n", kind, text.c_str());
}

VioOptions ChooseOptions(const RunArguments& arguments) {
  std::vector<std::string> overrides = arguments.overrides;
  if (!arguments.pipeline.empty()) overrides.push_back("pipeline=" + arguments.pipeline);
  const LoadedOptions loaded = LoadOptions(arguments.config, overrides);
  for (const std::string& notice : loaded.notices)
    Tell(arguments, "note", notice);
  VioOptions options = loaded.options;
  options.keeps_map = !arguments.save_map.empty();
  if (!arguments.map.empty())
    options.known_map = std::make_shared<SavedMap>(ReadSavedMap(arguments.map));
  options.loops.enabled = options.loops.enabled || options.keeps_map || options.known_map;
  return options;
}

/// Whether the run adds to the map in which it is looked for.
bool ExtendsMap(const RunArguments& arguments) {
  std::error_code error;
  return !arguments.map.empty() &&
         std::filesystem::equivalent(arguments.map, arguments.save_map, error);
}

/// Makes the folder for the map, so that what is wrong with it is known before the run. A map that
/// is there already is not replaced by one that does not have it.
void PrepareToSaveMap(const RunArguments& arguments) {
  if (arguments.save_map.empty()) return;
  const std::filesystem::path folder = arguments.save_map;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw OutputError("--save-map " + folder.string() + ": cannot be made: " + error.message());
  if (std::filesystem::exists(folder / kSavedMapName, error) && !ExtendsMap(arguments))
    throw ConfigError("--save-map " + folder.string() +
                      " has a map already: add to it with --map " + folder.string() +
                      ", or give another folder");
}

/// The map of runs before is never lost: what is written has it, and where the run was not found
/// nothing is written in its place. What goes wrong ends a run that is complete otherwise.
void SaveMap(const RunArguments& arguments, const RunRecord& record, bool is_complete) {
  if (!record.loops || !record.loops->map || record.loops->map->places.empty()) return;
  if (ExtendsMap(arguments) && !record.loops->localised) return;
  try {
    WriteSavedMap(arguments.save_map, *record.loops->map);
  } catch (const OutputError& error) {
    if (is_complete) throw;
    Tell(arguments, "warning", error.what());
  }
}

void WarnOfUnknownPlace(const RunArguments& arguments, RunRecord& record) {
  if (!record.loops || !record.loops->has_known_map || record.loops->localised) return;
  record.warnings.push_back("the run was not found in the map of " + arguments.map +
                            (record.loops->is_ambiguous
                                 ? ": it looks like more than one place there"
                                 : ": nothing that was seen looks like it") +
                            (record.loops->map ? "; the map stays as it was" : ""));
}

std::unique_ptr<Recording> OpenForRun(const RunArguments& arguments) {
  RecordingOptions options;
  options.calibration = {arguments.calibration, arguments.imu_calibration};
  options.topics = ParseTopics(arguments.topics);
  return OpenRecording(arguments.sequence, options);
}

std::string ShortNumber(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// A line of comment with what decides about the result beside the parameters; empty: the whole
/// recording with its own calibration.
std::string GivenBesideParameters(const RunArguments& arguments) {
  std::string given;
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) given += std::string(" ") + option + " " + value;
  };
  const RunRange& range = arguments.range;
  if (range.start_s > 0) add("--start", ShortNumber(range.start_s));
  if (std::isfinite(range.duration_s)) add("--duration", ShortNumber(range.duration_s));
  if (range.realtime) given += " --realtime";
  add("--calibration", arguments.calibration);
  add("--imu-calibration", arguments.imu_calibration);
  add("--map", arguments.map);
  for (const std::string& topic : arguments.topics)
    add("--topics", topic);
  // A name with a line break would end the comment.
  std::ranges::replace_if(
      given, [](char c) { return c == '\n' || c == '\r'; }, '?');
  return given.empty() ? given : "# Run with" + given + "\n";
}

void LogFrame(const VioOutput& output) {
  std::fprintf(stderr,
               "%s %s%s tracks %d landmarks %d cpu %.2f ms%s%s\n",
               FormatSeconds(output.t).c_str(),
               ToString(output.status),
               output.is_keyframe ? " keyframe" : "",
               output.num_tracks,
               output.num_landmarks,
               output.times.Total(),
               output.reason.empty() ? "" : ": ",
               output.reason.c_str());
}

/// Beside mesh.ply and map.ply.
void WriteGlbMeshes(const std::filesystem::path& folder, const RunRecord& record) {
  if (record.mesh) WriteGlbMesh(folder / "mesh.glb", *record.mesh);
  if (record.map) WriteGlbMesh(folder / "map.glb", *record.map);
}

/// When poses came, which may be on another thread than the outputs. Thread-safe.
class PoseClock {
 public:
  using Clock = std::chrono::steady_clock;

  void Add(const VioOutput& output) {
    const std::lock_guard lock(mutex_);
    poses_.emplace_back(output.t, Clock::now());
  }

  /// Of the frames in their order.
  Clock::time_point TakeTimeOf(Timestamp t) {
    const std::lock_guard lock(mutex_);
    while (!poses_.empty() && poses_.front().first != t)
      poses_.pop_front();
    if (poses_.empty()) return Clock::now();
    const Clock::time_point time = poses_.front().second;
    poses_.pop_front();
    return time;
  }

 private:
  std::mutex mutex_;
  std::deque<std::pair<Timestamp, Clock::time_point>> poses_;
};

/// Writes every n-th keyframe's mesh while the run goes on.
class MeshFiles {
 public:
  MeshFiles(const std::filesystem::path& folder, int every, bool as_glb)
      : folder_(folder), every_(every), as_glb_(as_glb) {}

  void Add(const VioOutput& output) {
    if (every_ == 0 || !output.mesh || num_seen_++ % every_ != 0) return;
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error) throw OutputError(folder_.string() + ": cannot be created: " + error.message());
    // A kill leaves it hidden, or not at all.
    const std::string name = std::to_string(output.t.ns) + (as_glb_ ? ".glb" : ".ply");
    const std::filesystem::path fresh = folder_ / (".new-" + name);
    if (as_glb_) {
      WriteGlbMesh(fresh, output.mesh->mesh);
    } else {
      WritePlyMesh(fresh, output.mesh->mesh);
      WriteVertexSigmas(folder_ / name, VertexSigmas(*output.mesh));
    }
    std::filesystem::rename(fresh, folder_ / name, error);
    if (error) throw OutputError((folder_ / name).string() + ": cannot be written");
  }

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  int every_;
  bool as_glb_;
  int num_seen_ = 0;
};

void WarnOfFullMap(double limit_mb, RunRecord& record) {
  if (!record.map_is_full) return;
  std::ostringstream text;
  text << "the map is full: it lacks surfaces that were seen after it had reached "
       << "mesh.map.max_memory_mb=" << limit_mb << "; raise that, or make mesh.map.voxel_m larger";
  record.warnings.push_back(text.str());
}

void WarnOfMissingMesh(const VioOptions& options, RunRecord& record) {
  if (options.mesh.enabled || options.pipeline == Formulation::kS) return;
  record.warnings.push_back(
      std::string("mesh.enabled=false: planes are found in the mesh, so pipeline ") +
      ToString(options.pipeline) + " has none and runs as S");
}

/// Who is told of each frame.
struct Observers {
  MeshFiles& mesh_files;
  LiveView* live = nullptr;
  PartialResult* partial = nullptr;
  Publisher* publisher = nullptr;
};

/// Runs the sequence with VioPipeline or ThreadedVio.
template <class Vio>
SequenceRun RunWith(Vio& vio,
                    VioFunctions functions,
                    Recording& recording,
                    const VioOptions& options,
                    const RunArguments& arguments,
                    const Observers& observers) {
  LiveView* const live = observers.live;
  Publisher* const publisher = observers.publisher;
  functions.add_stereo = [=, add = functions.add_stereo](const StereoFrame& frame) {
    if (live != nullptr) live->AddImage(frame.t, frame.left);
    if (publisher != nullptr) publisher->AddImage(frame.t, frame.left);
    return add(frame);
  };
  functions.add_imu = [&](const ImuSample& sample) { vio.AddImu(sample); };
  functions.result = [&] { return vio.TakeResult(); };
  ProgressBar bar(!arguments.quiet && !arguments.verbose);
  CatchInterrupts();
  const auto observer = [&](const RunProgress& progress, const VioOutput& output) {
    if (arguments.verbose) LogFrame(output);
    observers.mesh_files.Add(output);
    if (live != nullptr) {
      live->Add(output, MakeFrameRecord(output));
      if (live->WantsSceneUpdate()) vio.RequestSceneUpdate();
    }
    if (observers.partial != nullptr) {
      observers.partial->Add(progress, output);
      if (observers.partial->WantsSceneUpdate()) vio.RequestSceneUpdate();
    }
    if (publisher != nullptr) {
      publisher->Add(output);
      if (publisher->WantsSceneUpdate(output.t)) vio.RequestSceneUpdate();
    }
    bar.Update(progress.num_frames, progress.num_expected, ToString(output.status));
    if (arguments.on_frame) arguments.on_frame(progress.num_frames, progress.num_expected);
    return !WasInterrupted();
  };
  RunRange range = arguments.range;
  // Two threads are the pipeline's.
  constexpr int kMostDecoders = 8;
  range.num_decoders = std::clamp(arguments.threads - 2, 0, kMostDecoders);
  SequenceRun run = RunSequence(recording, functions, range, observer);
  WarnOfFullMap(options.mesh.map.max_memory_mb, run.record);
  WarnOfMissingMesh(options, run.record);
  return run;
}

SequenceRun RunPipeline(Recording& recording,
                        const StereoRig& rig,
                        const VioOptions& options,
                        const RunArguments& arguments,
                        const Observers& observers) {
  VioFunctions functions;
  PoseClock poses;
  const PoseObserver on_pose = [&](const VioOutput& output) { poses.Add(output); };
  functions.when_posed = [&](Timestamp t) { return poses.TakeTimeOf(t); };
  if (arguments.threads == 1) {
    VioPipeline vio(rig, recording.calibration()->imu_noise, options);
    functions.add_stereo = [&](const StereoFrame& f) {
      return std::vector{vio.AddStereo(f, on_pose)};
    };
    functions.finish = [] { return std::vector<VioOutput>(); };
    return RunWith(vio, functions, recording, options, arguments, observers);
  }
  ThreadedVio vio(rig, recording.calibration()->imu_noise, options, on_pose);
  functions.add_stereo = [&](const StereoFrame& f) { return vio.AddStereo(f); };
  functions.finish = [&] { return vio.Finish(); };
  return RunWith(vio, functions, recording, options, arguments, observers);
}

void PrintOutcome(const RunRecord& record, const std::string& folder) {
  const auto init_s = record.InitSeconds();
  const std::size_t num_poses = record.CausalTrajectory().size();
  std::printf("%zu poses of %d frames, %zu keyframes",
              num_poses,
              record.num_frames,
              record.keyframes.size());
  if (init_s) std::printf(", first pose after %.2f s", *init_s);
  std::printf(", %.1f x real time, %.0f MB -> %s\n",
              record.duration_s / record.wall_s,
              record.peak_rss_mb,
              folder.c_str());
}

void PrintLatency(const char* what, const std::optional<LatencyFigures>& figures) {
  if (!figures) return;
  std::printf(
      "from images to %s: median %.1f ms, 90 %% within %.1f, 99 %% within %.1f, at most %.1f\n",
      what,
      figures->median_ms,
      figures->p90_ms,
      figures->p99_ms,
      figures->max_ms);
}

int ExitCode(RunEnd end) {
  constexpr int kInput = 3, kEstimator = 4, kInterrupted = 128 + SIGINT;
  if (end == RunEnd::kRefused || end == RunEnd::kDamaged) return kInput;
  return end == RunEnd::kStopped ? kInterrupted : kEstimator;
}

void PrintFoxgloveAddress(const ViewServer& server) {
  constexpr std::string_view kHttp = "http";
  std::printf("open ws%s in Foxglove\n", server.url().substr(kHttp.size()).c_str());
  std::fflush(stdout);
}

/// For the page alone, which shows them beside the estimate; empty where the recording has none.
std::vector<StampedPose> TruePoses(const RunArguments& arguments) {
  if (arguments.view.empty() || !HasGroundTruth(arguments.sequence)) return {};
  try {
    return LoadGroundTruth(arguments.sequence).poses;
  } catch (const InputError& error) {
    Tell(arguments, "warning", std::string("the page shows no truth: ") + error.what());
    return {};
  }
}

/// Null where neither page nor messages were asked for.
std::unique_ptr<LiveView> OpenLiveView(const RunArguments& arguments,
                                       const VioOptions& options,
                                       const std::string& name,
                                       const std::filesystem::path& result,
                                       const StereoRig& rig,
                                       std::optional<SocketProtocol> protocol) {
  if (arguments.view.empty() && !protocol) return nullptr;
  const int port = arguments.view.empty() ? ParsePort("--publish", arguments.publish)
                                          : ParsePort("--view", arguments.view);
  LiveViewOptions view;
  view.name = name;
  view.map = options.mesh.map;
  view.result = result;
  view.truth = TruePoses(arguments);
  view.server.host = arguments.view_host;
  view.server.port = port;
  view.server.protocol = std::move(protocol);
  if (!IsLoopback(view.server.host)) view.server.token = RandomToken();
  auto live = std::make_unique<LiveView>(std::move(view), rig);
  if (!arguments.view.empty()) PrintAddress(live->server(), port);
  if (!arguments.publish.empty()) PrintFoxgloveAddress(live->server());
  return live;
}

/// What could not be published or recorded ends a run that is complete otherwise with an error; a
/// run that is not has a reason of its own.
void FinishPublishing(RunPublishing& publishing, bool is_complete, const RunArguments& arguments) {
  try {
    publishing.Finish();
  } catch (const OutputError& error) {
    if (is_complete) throw;
    Tell(arguments, "warning", error.what());
  }
}

/// Null where the recording is a bag, or cannot be opened again.
std::shared_ptr<CameraImages> ImagesAfterRun(const RunArguments& arguments) {
  if (arguments.view_exit) return nullptr;
  try {
    return OpenRecordedImages(arguments.sequence);
  } catch (const InputError&) {
    return nullptr;
  }
}

/// Until Ctrl-C, unless that has ended the run or nobody wants to look.
void KeepShowing(LiveView* live, const RunArguments& arguments, const SequenceRun& run) {
  if (live == nullptr || arguments.view.empty() || run.end == RunEnd::kStopped) return;
  try {
    live->ShowResult(run.end == RunEnd::kComplete ? 0 : ExitCode(run.end),
                     run.message,
                     ImagesAfterRun(arguments));
  } catch (const std::exception& error) {  // the run ends as it ended
    std::fprintf(stderr, "facet: warning: the result cannot be shown: %s\n", error.what());
  }
  if (arguments.view_exit) return live->WaitUntilSent();
  std::printf("the result is at %s; Ctrl-C ends\n", live->server().url().c_str());
  std::fflush(stdout);
  WaitForInterrupt();
}

void KeepWhatAKillLeft(const std::string& out) {
  const std::filesystem::path kept = KeepInterrupted(out);
  if (kept.empty()) return;
  std::fprintf(stderr,
               "facet: note: a run was killed that wrote to %s; what it left is now %s\n",
               out.c_str(),
               kept.c_str());
}

/// What is known of a run when it begins.
void DescribeRun(const Recording& recording,
                 const VioOptions& options,
                 const RunArguments& arguments,
                 RunRecord& record) {
  record.version = FACET_VERSION;
  record.sequence = recording.name();
  record.calibration = recording.calibration()->source;
  record.pipeline = ToString(options.pipeline);
  record.threads = arguments.threads;
  record.config = GivenBesideParameters(arguments) + FormatOptions(options);
}

/// The meshes of a run are part of its result.
void MoveMeshes(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  if (!std::filesystem::exists(from, error)) return;
  std::filesystem::rename(from, to, error);
  if (error) throw OutputError(to.string() + ": cannot be created: " + error.message());
}

}  // namespace

void RunCommand(const RunArguments& arguments) {
  const VioOptions options = ChooseOptions(arguments);
  PrepareToSaveMap(arguments);
  const std::unique_ptr<Recording> opened = OpenForRun(arguments);
  Recording& recording = *opened;
  if (arguments.verbose)
    std::fprintf(stderr, "calibration: %s\n", recording.calibration()->source.c_str());
  const std::string out = arguments.out.empty()
                              ? "runs/" + recording.name() + "-" + ToString(options.pipeline)
                              : arguments.out;
  KeepWhatAKillLeft(out);
  ResultFolder folder(out);
  AlignedRig aligned{recording.calibration()->rig, {}, {}};
  if (options.check_calibration) aligned = AlignStereo(recording, arguments.range.start_s);
  if (!aligned.refusal.empty()) {
    throw InputError(recording.calibration()->source + ": the calibration cannot be right: " +
                     aligned.refusal + " (check_calibration=false goes on with it)");
  }
  std::unique_ptr<LiveView> live;  // longer than what is published
  RunPublishing publishing(arguments, recording.name());
  live = OpenLiveView(
      arguments, options, recording.name(), folder.target(), aligned.rig, publishing.Protocol());
  publishing.Begin(aligned.rig, options.mesh.map, live.get());
  RunRecord about;
  DescribeRun(recording, options, arguments, about);
  std::unique_ptr<PartialResult> partial;
  if (arguments.range.realtime)
    partial = std::make_unique<PartialResult>(out, about, options.mesh.map);
  MeshFiles mesh_files((partial ? partial->folder() : folder.staging()) / "meshes",
                       arguments.mesh_every,
                       arguments.mesh_format == "glb");
  SequenceRun run = RunPipeline(recording,
                                aligned.rig,
                                options,
                                arguments,
                                {mesh_files, live.get(), partial.get(), publishing.publisher()});
  if (!aligned.warning.empty()) run.record.warnings.push_back(aligned.warning);
  for (const std::string& warning :
       InflationWarnings(recording.calibration()->imu_noise, options.estimator.imu))
    run.record.warnings.push_back(warning);
  WarnOfUnknownPlace(arguments, run.record);
  DescribeRun(recording, options, arguments, run.record);
  WriteResult(folder.staging(), run.record);
  if (arguments.mesh_format == "glb") WriteGlbMeshes(folder.staging(), run.record);
  if (partial) {
    for (const char* name : {"meshes", kSigmaFolder})
      MoveMeshes(partial->folder() / name, folder.staging() / name);
  }
  folder.Commit();
  if (partial) partial->Remove();
  for (const std::string& warning : run.record.warnings) {
    if (warning != run.message) Tell(arguments, "warning", warning);
  }
  const bool is_complete = run.end == RunEnd::kComplete;
  if (is_complete && !arguments.quiet) PrintOutcome(run.record, folder.target().string());
  if (arguments.range.realtime && !arguments.quiet) {
    PrintLatency("pose", PoseLatency(run.record.frames));
    PrintLatency("mesh, on keyframes", MeshLatency(run.record.frames));
  }
  SaveMap(arguments, run.record, is_complete);
  FinishPublishing(publishing, is_complete, arguments);
  KeepShowing(live.get(), arguments, run);
  if (!is_complete) throw RunEndedError(ExitCode(run.end), run.message);
}

}  // namespace facet
