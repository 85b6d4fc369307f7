// SPDX-License-Identifier: BSD-2-Clause
// `facet run`: from a recording to a result folder.
#include "run.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "align_stereo.h"
#include "interrupts.h"
#include "load_options.h"
#include "progress_bar.h"
#include "run_recorder.h"
#include "run_sequence.h"
#include "view.h"

#include "facet/estimator/window/imu_link.h"
#include "facet/io/errors.h"
#include "facet/io/glb_writer.h"
#include "facet/io/ply_writer.h"
#include "facet/io/result_folder.h"
#include "facet/io/result_writer.h"
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
  return loaded.options;
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
    const std::string stem = std::to_string(output.t.ns);
    if (as_glb_) {
      WriteGlbMesh(folder_ / (stem + ".glb"), output.mesh->mesh);
    } else {
      WritePlyMesh(folder_ / (stem + ".ply"), output.mesh->mesh);
    }
  }

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
  if (live != nullptr) {
    functions.add_stereo = [live, add = functions.add_stereo](const StereoFrame& frame) {
      live->AddImage(frame.t, frame.left);
      return add(frame);
    };
  }
  functions.add_imu = [&](const ImuSample& sample) { vio.AddImu(sample); };
  functions.result = [&] { return vio.Result(); };
  ProgressBar bar(!arguments.quiet && !arguments.verbose);
  CatchInterrupts();
  const auto observer = [&](int done, int total, const VioOutput& output) {
    if (arguments.verbose) LogFrame(output);
    observers.mesh_files.Add(output);
    if (live != nullptr) {
      live->Add(output, MakeFrameRecord(output));
      if (live->WantsSceneUpdate()) vio.RequestSceneUpdate();
    }
    bar.Update(done, total, ToString(output.status));
    if (arguments.on_frame) arguments.on_frame(done, total);
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
  if (arguments.threads == 1) {
    VioPipeline vio(rig, recording.calibration()->imu_noise, options);
    functions.add_stereo = [&](const StereoFrame& f) { return std::vector{vio.AddStereo(f)}; };
    functions.finish = [] { return std::vector<VioOutput>(); };
    return RunWith(vio, functions, recording, options, arguments, observers);
  }
  ThreadedVio vio(rig, recording.calibration()->imu_noise, options);
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

int ExitCode(RunEnd end) {
  constexpr int kInput = 3, kEstimator = 4, kInterrupted = 128 + SIGINT;
  if (end == RunEnd::kRefused || end == RunEnd::kDamaged) return kInput;
  return end == RunEnd::kStopped ? kInterrupted : kEstimator;
}

/// Null where it was not asked for.
std::unique_ptr<LiveView> OpenLiveView(const RunArguments& arguments,
                                       const VioOptions& options,
                                       const std::string& name,
                                       const std::filesystem::path& result,
                                       const StereoRig& rig) {
  if (arguments.view.empty()) return nullptr;
  LiveViewOptions view;
  view.name = name;
  view.map = options.mesh.map;
  view.result = result;
  view.server.host = arguments.view_host;
  view.server.port = ParsePort(arguments.view);
  if (!IsLoopback(view.server.host)) view.server.token = RandomToken();
  auto live = std::make_unique<LiveView>(std::move(view), rig);
  PrintAddress(live->server(), ParsePort(arguments.view));
  return live;
}

/// Until Ctrl-C, unless that has ended the run or nobody wants to look.
void KeepShowing(LiveView* live, const RunArguments& arguments, const SequenceRun& run) {
  if (live == nullptr || run.end == RunEnd::kStopped) return;
  try {
    live->ShowResult(run.end == RunEnd::kComplete ? 0 : ExitCode(run.end), run.message);
  } catch (const std::exception& error) {  // the run ends as it ended
    std::fprintf(stderr, "facet: warning: the result cannot be shown: %s\n", error.what());
  }
  if (arguments.view_exit) return;
  std::printf("the result is at %s; Ctrl-C ends\n", live->server().url().c_str());
  std::fflush(stdout);
  WaitForInterrupt();
}

}  // namespace

void RunCommand(const RunArguments& arguments) {
  const VioOptions options = ChooseOptions(arguments);
  const std::unique_ptr<Recording> opened = OpenForRun(arguments);
  Recording& recording = *opened;
  if (arguments.verbose)
    std::fprintf(stderr, "calibration: %s\n", recording.calibration()->source.c_str());
  ResultFolder folder(arguments.out.empty()
                          ? "runs/" + recording.name() + "-" + ToString(options.pipeline)
                          : arguments.out);

  MeshFiles mesh_files(
      folder.staging() / "meshes", arguments.mesh_every, arguments.mesh_format == "glb");
  AlignedRig aligned{recording.calibration()->rig, {}, {}};
  if (options.check_calibration) aligned = AlignStereo(recording, arguments.range.start_s);
  if (!aligned.refusal.empty()) {
    throw InputError(recording.calibration()->source + ": the calibration cannot be right: " +
                     aligned.refusal + " (check_calibration=false goes on with it)");
  }
  const std::unique_ptr<LiveView> live =
      OpenLiveView(arguments, options, recording.name(), folder.target(), aligned.rig);
  SequenceRun run =
      RunPipeline(recording, aligned.rig, options, arguments, {mesh_files, live.get()});
  if (!aligned.warning.empty()) run.record.warnings.push_back(aligned.warning);
  for (const std::string& warning :
       InflationWarnings(recording.calibration()->imu_noise, options.estimator.imu))
    run.record.warnings.push_back(warning);
  run.record.version = FACET_VERSION;
  run.record.pipeline = ToString(options.pipeline);
  run.record.threads = arguments.threads;
  run.record.config = GivenBesideParameters(arguments) + FormatOptions(options);
  WriteResult(folder.staging(), run.record);
  if (arguments.mesh_format == "glb") WriteGlbMeshes(folder.staging(), run.record);
  folder.Commit();

  for (const std::string& warning : run.record.warnings) {
    if (warning != run.message) Tell(arguments, "warning", warning);
  }
  const bool is_complete = run.end == RunEnd::kComplete;
  if (is_complete && !arguments.quiet) PrintOutcome(run.record, folder.target().string());
  KeepShowing(live.get(), arguments, run);
  if (!is_complete) throw RunEndedError(ExitCode(run.end), run.message);
}

}  // namespace facet
