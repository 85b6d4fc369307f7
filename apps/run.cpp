// SPDX-License-Identifier: BSD-2-Clause
// `facet run`: from a recording to a result folder.
#include "run.h"

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "load_options.h"
#include "number_check.h"
#include "progress_bar.h"
#include "run_sequence.h"
#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "facet/io/asl_dataset.h"
#include "facet/io/errors.h"
#include "facet/io/glb_writer.h"
#include "facet/io/ply_writer.h"
#include "facet/io/result_folder.h"
#include "facet/io/result_writer.h"
#include "facet/pipeline/threaded_vio.h"
#include "facet/pipeline/vio_pipeline.h"

namespace facet {
namespace {

struct RunArguments {
  std::string sequence, out, config, calibration, imu_calibration;
  std::string pipeline;  // empty: what the configuration says
  std::vector<std::string> overrides;
  RunRange range;
  int threads = 1;
  int mesh_every = 0;
  std::string mesh_format = "ply";
  bool quiet = false, verbose = false;
};

volatile std::sig_atomic_t interrupted = 0;

/// The first Ctrl-C ends the run in good order, the second one kills the program.
void CatchInterrupts() {
  struct sigaction action {};
  action.sa_handler = [](int) { interrupted = 1; };
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

std::shared_ptr<spdlog::logger> MakeLog(bool verbose) {
  auto log =
      std::make_shared<spdlog::logger>("facet", std::make_shared<spdlog::sinks::stderr_sink_st>());
  log->set_pattern("%v");
  log->set_level(verbose ? spdlog::level::debug : spdlog::level::warn);
  return log;
}

VioOptions ChooseOptions(const RunArguments& arguments) {
  std::vector<std::string> overrides = arguments.overrides;
  if (!arguments.pipeline.empty()) overrides.push_back("pipeline=" + arguments.pipeline);
  const LoadedOptions loaded = LoadOptions(arguments.config, overrides);
  for (const std::string& notice : loaded.notices)
    std::fprintf(stderr, "facet: note: %s\n", notice.c_str());
  return loaded.options;
}

void LogFrame(spdlog::logger& log, const VioOutput& output) {
  log.debug("{} {}{} tracks {} landmarks {} cpu {:.2f} ms{}{}",
            FormatSeconds(output.t),
            ToString(output.status),
            output.is_keyframe ? " keyframe" : "",
            output.num_tracks,
            output.num_landmarks,
            output.times.Total(),
            output.reason.empty() ? "" : ": ",
            output.reason);
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
    std::filesystem::create_directories(folder_);
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
  record.warnings.push_back(
      fmt::format("the map is full: it lacks surfaces that were seen after it had reached "
                  "mesh.map.max_memory_mb={:g}; raise that, or make mesh.map.voxel_m larger",
                  limit_mb));
}

void WarnOfMissingMesh(const VioOptions& options, RunRecord& record) {
  if (options.mesh.enabled || options.pipeline == Formulation::kS) return;
  record.warnings.push_back(fmt::format(
      "mesh.enabled=false: planes are found in the mesh, so pipeline {} has none and runs as S",
      ToString(options.pipeline)));
}

/// Runs the sequence with VioPipeline or ThreadedVio.
template <class Vio>
SequenceRun RunWith(Vio& vio,
                    VioFunctions functions,
                    AslDataset& dataset,
                    const VioOptions& options,
                    const RunArguments& arguments,
                    MeshFiles& mesh_files,
                    spdlog::logger& log) {
  functions.add_imu = [&](const ImuSample& sample) { vio.AddImu(sample); };
  functions.result = [&] { return vio.Result(); };
  ProgressBar bar(!arguments.quiet && !arguments.verbose);
  CatchInterrupts();
  const auto observer = [&](int done, int total, const VioOutput& output) {
    LogFrame(log, output);
    mesh_files.Add(output);
    bar.Update(done, total, ToString(output.status));
    return interrupted == 0;
  };
  SequenceRun run = RunSequence(dataset, functions, arguments.range, observer);
  WarnOfFullMap(options.mesh.map.max_memory_mb, run.record);
  WarnOfMissingMesh(options, run.record);
  return run;
}

SequenceRun RunPipeline(AslDataset& dataset,
                        const VioOptions& options,
                        const RunArguments& arguments,
                        MeshFiles& mesh_files,
                        spdlog::logger& log) {
  VioFunctions functions;
  if (arguments.threads == 1) {
    VioPipeline vio(dataset.rig(), dataset.imu_noise(), options);
    functions.add_stereo = [&](const StereoFrame& f) { return std::vector{vio.AddStereo(f)}; };
    functions.finish = [] { return std::vector<VioOutput>(); };
    return RunWith(vio, functions, dataset, options, arguments, mesh_files, log);
  }
  ThreadedVio vio(dataset.rig(), dataset.imu_noise(), options);
  functions.add_stereo = [&](const StereoFrame& f) { return vio.AddStereo(f); };
  functions.finish = [&] { return vio.Finish(); };
  return RunWith(vio, functions, dataset, options, arguments, mesh_files, log);
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
  constexpr int kEstimator = 4, kInterrupted = 128 + SIGINT;
  return end == RunEnd::kStopped ? kInterrupted : kEstimator;
}

void Run(const RunArguments& arguments) {
  const VioOptions options = ChooseOptions(arguments);
  const auto log = MakeLog(arguments.verbose);
  AslDataset dataset(arguments.sequence, {arguments.calibration, arguments.imu_calibration});
  log->debug("calibration: {}", dataset.calibration_source());
  ResultFolder folder(arguments.out.empty()
                          ? "runs/" + dataset.name() + "-" + ToString(options.pipeline)
                          : arguments.out);

  MeshFiles mesh_files(
      folder.staging() / "meshes", arguments.mesh_every, arguments.mesh_format == "glb");
  SequenceRun run = RunPipeline(dataset, options, arguments, mesh_files, *log);
  run.record.version = FACET_VERSION;
  run.record.pipeline = ToString(options.pipeline);
  run.record.threads = arguments.threads;
  run.record.config = FormatOptions(options);
  WriteResult(folder.staging(), run.record);
  if (arguments.mesh_format == "glb") WriteGlbMeshes(folder.staging(), run.record);
  folder.Commit();

  for (const std::string& warning : run.record.warnings) {
    if (warning != run.message) log->warn("facet: warning: {}", warning);
  }
  if (run.end != RunEnd::kComplete) throw RunEndedError(ExitCode(run.end), run.message);
  if (!arguments.quiet) PrintOutcome(run.record, folder.target().string());
}

void AddOptions(CLI::App& command, RunArguments& a) {
  command.add_option("SEQUENCE", a.sequence, "folder that holds mav0/, or mav0/ itself")
      ->required();
  command.add_option("--out", a.out, "result folder (default: runs/<sequence>-<pipeline>)");
  command.add_option("--pipeline", a.pipeline, "S, SP or SPR (default: SPR)")
      ->check(CLI::IsMember({"S", "SP", "SPR"}));
  command.add_option("--config", a.config, "YAML with any subset of the parameters");
  command.add_option("--set", a.overrides, "key.path=value, repeatable; wins over the file")
      ->allow_extra_args(false);
  command.add_option("--calibration", a.calibration, "Kalibr camchain.yaml, or EuRoC folder");
  command.add_option(
      "--imu-calibration", a.imu_calibration, "Kalibr imu.yaml, or EuRoC sensor.yaml");
  command.add_option("--start", a.range.start_s, "seconds after the first stereo pair")
      ->check(NonNegativeNumber());
  command.add_option("--duration", a.range.duration_s, "seconds")->check(PositiveNumber());
  command
      .add_option("--threads",
                  a.threads,
                  "1: one thread; 2 and more: front end and back end overlap, same results")
      ->check(CLI::Range(1, 64));
  command.add_flag("--realtime", a.range.realtime, "recorded speed; drop what arrives while busy");
  command
      .add_option("--imu-history", a.range.imu_history_s, "seconds of IMU before the first pair")
      ->check(NonNegativeNumber());
  command
      .add_option("--mesh-every",
                  a.mesh_every,
                  "also write meshes/<timestamp_ns>.ply every N keyframes; 0: none")
      ->check(NonNegativeNumber());
  command
      .add_option("--mesh-format",
                  a.mesh_format,
                  "ply; or glb: meshes/ in that format, and mesh.glb and map.glb besides the .ply")
      ->check(CLI::IsMember({"ply", "glb"}));
  auto* quiet = command.add_flag("--quiet", a.quiet, "no progress bar");
  command.add_flag("--verbose", a.verbose, "debug log")->excludes(quiet);
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  auto* command = app.add_subcommand("run", "Estimate the trajectory of a recording");
  auto arguments = std::make_shared<RunArguments>();
  AddOptions(*command, *arguments);
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace facet
