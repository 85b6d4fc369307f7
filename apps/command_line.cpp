// SPDX-License-Identifier: BSD-2-Clause
#include "command_line.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <thread>

#include "check.h"
#include "compare.h"
#include "config.h"
#include "convert.h"
#include "evaluate.h"
#include "info.h"
#include "map.h"
#include "picture.h"
#include "run.h"
#include "view.h"
#include <CLI/CLI.hpp>

#include "facet/io/errors.h"

#ifdef FACET_HAS_SIMULATOR
#include "simulate.h"

#include "facet/sim/flight.h"
#endif

namespace facet {
namespace {

// Checks of numbers that say in a few words what is wrong; CLI11's own ones print the largest
// number there is.
CLI::Validator NumberCheck(bool may_be_zero) {
  const auto check = [may_be_zero](const std::string& text) {
    double value = 0;
    const bool is_number = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
    if (is_number && (value > 0 || (may_be_zero && value == 0))) return std::string();
    return "'" + text + "' is not a " + (may_be_zero ? "number of at least 0" : "positive number");
  };
  return {check, may_be_zero ? "NUMBER >= 0" : "NUMBER > 0"};
}

CLI::Validator PositiveNumber() {
  return NumberCheck(false);
}

CLI::Validator NonNegativeNumber() {
  return NumberCheck(true);
}

void AddTopics(CLI::App& command, std::vector<std::string>& topics) {
  command.add_option("--topics",
                     topics,
                     "left=NAME right=NAME imu=NAME (or gyro=NAME accel=NAME) of a bag, where its "
                     "types and names leave a choice");
}

void AddHost(CLI::App& command, std::string& host) {
  command
      .add_option("--host",
                  host,
                  "address that the viewer listens on; who is not on this machine needs the token "
                  "in the printed address")
      ->capture_default_str();
}

void AddViewOptions(CLI::App& command, RunArguments& a) {
  command.add_flag("--view{8470}",
                   a.view,
                   "show the run in the browser while it goes on, and its result until Ctrl-C; "
                   "--view=PORT: the first port that is tried");
  AddHost(command, a.view_host);
  command.add_flag("--view-exit", a.view_exit, "with --view: end with the run");
  command.add_flag(
      "--publish{8765}",
      a.publish,
      "send state, path, mesh, map, planes and images to Foxglove (WebSocket) while the "
      "run goes on; --publish=PORT: the first port that is tried, unless --view says");
  command.add_option("--record", a.record, "MCAP file for the messages of --publish");
}

void AddOptions(CLI::App& command, RunArguments& a) {
  command
      .add_option(
          "RECORDING",
          a.sequence,
          "folder (mav0/, KITTI raw, or left/, right/ and imu.csv), ROS 1 bag, ROS 2 bag (.db3, "
          ".mcap, folder)")
      ->required();
  AddTopics(command, a.topics);
  command.add_option("--out", a.out, "result folder (default: runs/<sequence>-<pipeline>)");
  command.add_option("--pipeline", a.pipeline, "S, SP or SPR (default: SPR)")
      ->check(CLI::IsMember({"S", "SP", "SPR"}));
  command.add_option("--config", a.config, "YAML with any subset of the parameters");
  command.add_option("--set", a.overrides, "key.path=value, repeatable; wins over the file")
      ->allow_extra_args(false);
  command.add_option("--calibration",
                     a.calibration,
                     "Kalibr camchain.yaml, Basalt calibration.json, or EuRoC folder");
  command.add_option(
      "--imu-calibration", a.imu_calibration, "Kalibr imu.yaml, or EuRoC sensor.yaml");
  command.add_option("--start", a.range.start_s, "seconds after the first stereo pair")
      ->check(NonNegativeNumber());
  command.add_option("--duration", a.range.duration_s, "seconds")->check(PositiveNumber());
  command
      .add_option("--threads",
                  a.threads,
                  "1: one thread; 2: front end and back end overlap; 3 and more: the others decode "
                  "the next images; same results")
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
  command.add_option(
      "--map", a.map, "folder with a map of places that --save-map wrote: finds the run in it");
  command.add_option("--save-map",
                     a.save_map,
                     "folder for the map of places, with that of --map if the run was found in it");
  AddViewOptions(command, a);
  auto* quiet = command.add_flag("--quiet", a.quiet, "no progress bar");
  command.add_flag("--verbose", a.verbose, "debug log")->excludes(quiet);
}

void AddOptions(CLI::App& command, EvaluateArguments& a) {
  command.add_option("RESULT", a.result, "result folder, or trajectory file (TUM, EuRoC csv)")
      ->required();
  command.add_option("--truth", a.truth, "sequence folder, or trajectory file")->required();
  command.add_option("--against", a.against, "more results, for comparison in the table");
  command.add_option("--alignment", a.alignment, "se3, yaw (rotation about z only) or sim3")
      ->check(CLI::IsMember({"se3", "yaw", "sim3"}))
      ->capture_default_str();
  command
      .add_option(
          "--rpe-lengths",
          a.rpe_lengths_m,
          "path lengths [m] for relative errors; default: 1,2,5,10,20,... as far as the path goes")
      ->delimiter(',')
      ->check(PositiveNumber());
  command.add_option("--report", a.report, "folder for report.html: plots and tables on one page");
  command.add_flag("--align-time",
                   a.align_time,
                   "estimate the offset between the two clocks (at most 0.5 s) and remove it");
  command
      .add_option(
          "--parts",
          a.parts,
          "what to judge beside the trajectory, where there is truth for it: "
          "mesh,planes,consistency (default), or trajectory for nothing else; what is named "
          "must be there")
      ->delimiter(',')
      ->check(CLI::IsMember({"trajectory", "mesh", "planes", "consistency"}));
}

void AddOptions(CLI::App& command, CompareArguments& a) {
  command.add_option("SEQUENCE", a.sequences, "folders with ground truth")->required();
  command.add_option("--pipelines", a.pipelines, "S,SP,SPR; the first one is the reference")
      ->delimiter(',')
      ->check(CLI::IsMember({"S", "SP", "SPR"}))
      ->capture_default_str();
  command
      .add_option("--starts", a.starts, "runs per combination, from 0, 0.1, 0.2 ... s; 9 to judge")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_option("--out", a.out, "folder for the runs and the tables; a study goes on there")
      ->required();
  command.add_option("--jobs", a.jobs, "runs at the same time, one core each")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command.add_flag("--slurm",
                   a.uses_slurm,
                   "the runs are a job array of Slurm, --jobs of them at the same time");
  command
      .add_option("--slurm-option",
                  a.slurm_options,
                  "one more argument of sbatch, repeatable: --slurm-option=--partition=short")
      ->allow_extra_args(false)
      ->needs("--slurm");
  command.add_option("--cell", a.cell, "the run of this number alone")
      ->check(CLI::Range(0, 1 << 30))
      ->group("");  // not listed: what a job of Slurm does
  command.add_option("--config", a.configs, "NAME=FILE, repeatable: each one with each pipeline")
      ->allow_extra_args(false);
  command.add_option("--set", a.overrides, "key.path=value for all runs, repeatable")
      ->allow_extra_args(false);
  command
      .add_option("--run-option",
                  a.run_options,
                  "one more argument of facet run for all runs, repeatable: "
                  "--run-option=--mesh-every=5 (10 if not given; 0: none)")
      ->allow_extra_args(false);
  command.add_option("--duration", a.duration_s, "seconds of each run")->check(PositiveNumber());
  command.add_option(
      "--report", a.report, "folder for report.html with figures of each sequence's first start");
  command.add_flag("--quiet", a.is_quiet, "no line per run");
}

void AddOptions(CLI::App& command, ConfigArguments& a) {
  command.add_option("--config", a.file, "YAML with any subset of the parameters");
  command.add_option("--set", a.overrides, "key.path=value, repeatable; wins over the file")
      ->allow_extra_args(false);
  command.add_flag("--all", a.all, "every parameter, also those for experts");
}

void AddRun(CLI::App& app) {
  auto* command = app.add_subcommand("run", "Estimate the trajectory of a recording");
  auto arguments = std::make_shared<RunArguments>();
  AddOptions(*command, *arguments);
  command->callback([arguments] { RunCommand(*arguments); });
}

void AddInfo(CLI::App& app) {
  auto* command = app.add_subcommand(
      "info", "What is in a recording: topics, rates, gaps, resolution, calibration");
  auto arguments = std::make_shared<InfoArguments>();
  command->add_option("RECORDING", arguments->recording, "as for facet run")->required();
  AddTopics(*command, arguments->topics);
  command->add_option("--calibration", arguments->calibration, "as for facet run");
  command->add_option("--imu-calibration", arguments->imu_calibration, "as for facet run");
  command->callback([arguments] { InfoCommand(*arguments); });
}

void AddCheck(CLI::App& app) {
  auto* command = app.add_subcommand(
      "check", "Say whether a recording can work and what is wrong with it; exit code 0 or 3");
  auto arguments = std::make_shared<CheckArguments>();
  command->add_option("RECORDING", arguments->recording, "as for facet run")->required();
  AddTopics(*command, arguments->topics);
  command->add_option("--calibration", arguments->calibration, "as for facet run");
  command->add_option("--imu-calibration", arguments->imu_calibration, "as for facet run");
  command->add_option(
      "--json", arguments->json, "also write the report to this file, for programs");
  command->add_flag("--quiet", arguments->quiet, "no progress bar");
  command->callback([arguments] { CheckCommand(*arguments); });
}

void AddConvert(CLI::App& app) {
  auto* command = app.add_subcommand(
      "convert", "Write a recording as a folder in the ASL/EuRoC layout, or as MCAP");
  auto arguments = std::make_shared<ConvertArguments>();
  command->add_option("RECORDING", arguments->recording, "as for facet run")->required();
  command
      ->add_option(
          "OUT", arguments->out, "folder, in which an interrupted conversion goes on; or file.mcap")
      ->required();
  command->add_option("--compression", arguments->compression, "of an MCAP file: zstd or none")
      ->check(CLI::IsMember({"zstd", "none"}))
      ->capture_default_str();
  AddTopics(*command, arguments->topics);
  command->add_option("--calibration", arguments->calibration, "as for facet run");
  command->add_option("--imu-calibration", arguments->imu_calibration, "as for facet run");
  command->add_flag("--quiet", arguments->quiet, "no progress bar");
  command->callback([arguments] { ConvertCommand(*arguments); });
}

void AddEvaluate(CLI::App& app) {
  auto* command =
      app.add_subcommand("evaluate", "Judge a trajectory, meshes and planes against ground truth");
  auto arguments = std::make_shared<EvaluateArguments>();
  AddOptions(*command, *arguments);
  command->callback([arguments, command] {
    arguments->parts_are_named = command->count("--parts") > 0;
    EvaluateCommand(*arguments);
  });
}

void AddCompare(CLI::App& app) {
  auto* command = app.add_subcommand(
      "compare", "Run sequences with several pipelines, configurations and starts, and compare");
  auto arguments = std::make_shared<CompareArguments>();
  AddOptions(*command, *arguments);
  command->callback([arguments] { CompareCommand(*arguments); });
}

void AddConfig(CLI::App& app) {
  auto* command =
      app.add_subcommand("config", "Print the parameters with their values and meanings");
  auto arguments = std::make_shared<ConfigArguments>();
  AddOptions(*command, *arguments);
  command->callback([arguments] { ConfigCommand(*arguments); });
}

void AddView(CLI::App& app) {
  auto* command = app.add_subcommand("view", "Show one result, or two, in the browser");
  auto arguments = std::make_shared<ViewArguments>();
  command->add_option("RESULT", arguments->results, "result folders of facet run; two to compare")
      ->required()
      ->expected(1, 2);
  command->add_option("--truth", arguments->truth, "sequence folder, or trajectory file");
  command->add_option("--recording",
                      arguments->recording,
                      "folder with image files: the left images are shown, with the mesh over them "
                      "(default: --truth, if it has images)");
  command->add_option("--port", arguments->port, "the first one that is tried; 0: any that is free")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  AddHost(*command, arguments->host);
  command->callback([arguments] { ViewCommand(*arguments); });
}

void AddMap(CLI::App& app) {
  auto* command = app.add_subcommand("map", "What facet run --save-map has kept for later runs");
  command->require_subcommand(1);
  auto arguments = std::make_shared<MapArguments>();
  auto* info = command->add_subcommand("info", "Runs, places and points of a map");
  info->add_option("MAP", arguments->map, "folder of facet run --save-map")->required();
  info->callback([arguments] { MapInfoCommand(*arguments); });
  auto* merge = command->add_subcommand("merge", "Two maps as one, in the frame of the first");
  merge->add_option("FIRST", arguments->map, "folder of facet run --save-map")->required();
  merge->add_option("SECOND", arguments->second, "another one, of the same places")->required();
  merge->add_option("OUT", arguments->out, "folder for both")->required();
  merge->callback([arguments] { MapMergeCommand(*arguments); });
  auto* localise = command->add_subcommand("localise", "Where in a map a recording is");
  localise->add_option("MAP", arguments->map, "folder of facet run --save-map")->required();
  localise->add_option("RECORDING", arguments->recording, "as for facet run")->required();
  localise->add_option("--calibration", arguments->calibration, "as for facet run");
  localise->add_option("--imu-calibration", arguments->imu_calibration, "as for facet run");
  localise->add_option("--set", arguments->overrides, "as for facet run");
  localise->add_option("--start", arguments->start_s, "seconds after the first stereo pair")
      ->check(NonNegativeNumber());
  localise->add_option("--duration", arguments->duration_s, "seconds until it gives up")
      ->check(PositiveNumber())
      ->capture_default_str();
  localise->callback([arguments] { MapLocaliseCommand(*arguments); });
  auto* out = command->add_subcommand("export", "Its points as PLY, or its places as a trajectory");
  out->add_option("MAP", arguments->map, "folder of facet run --save-map")->required();
  out->add_option("OUT", arguments->out, "file.ply, or file.tum")->required();
  out->add_option("--run", arguments->run, "of a .tum: the places of this run alone, from 1 on")
      ->check(PositiveNumber());
  out->callback([arguments] { MapExportCommand(*arguments); });
}

void AddPicture(CLI::App& app) {
  auto* command = app.add_subcommand("picture", "Draw a result as a PNG, without a display");
  auto arguments = std::make_shared<PictureArguments>();
  PictureOptions& o = arguments->options;
  command->add_option("RESULT", arguments->result, "result folder of facet run")->required();
  command->add_option("OUT", arguments->out, "file.png")->required();
  command->add_option("--view", o.view, "outside or top")
      ->check(CLI::IsMember({"outside", "top"}))
      ->capture_default_str();
  command->add_option("--from", arguments->from, "X Y Z [m] of the eye, in W")->expected(3);
  command->add_option("--to", arguments->to, "X Y Z [m] that it looks at")->expected(3);
  command->add_option("--colour", o.colour, "plane, normal, height or image")
      ->check(CLI::IsMember({"plane", "normal", "height", "image"}))
      ->capture_default_str();
  command->add_option("--mesh", o.mesh, "map, or the horizon at the end")
      ->check(CLI::IsMember({"map", "horizon"}))
      ->capture_default_str();
  command->add_option("--size", arguments->size, "WIDTH HEIGHT in pixels; default: 1600 1000")
      ->expected(2)
      ->check(CLI::Range(16, 8192));
  command->add_flag("--dark", o.is_dark, "dark background");
  command->add_flag("--back-sides", o.has_back_sides, "do not look through surfaces from behind");
  command->add_flag("!--no-trajectory", o.has_trajectory, "without the trajectory");
  command->add_flag("!--no-labels", o.has_labels, "without outlines and labels of planes");
  command->callback([arguments] { PictureCommand(*arguments); });
}

#ifdef FACET_HAS_SIMULATOR

void AddCalibrationOptions(CLI::App& command, SimulateArguments& a) {
  command
      .add_option("--draw-calibration",
                  a.request.drawn_calibration,
                  "a seed: what a careful calibration would have written; truth/ has the exact one")
      ->check(NonNegativeNumber());
  command
      .add_option(
          "--draw-parts", a.drawn_parts, "lens,imu,time,scale (all): which parts of it are drawn")
      ->delimiter(',')
      ->needs("--draw-calibration");
  command
      .add_option("--lens-misfit",
                  a.request.lens_misfit,
                  "a seed: lenses that their model describes to 0.13 px only")
      ->check(NonNegativeNumber());
  command
      .add_flag_callback(
          "--calibration-error",
          [] {
            throw ConfigError(
                "--calibration-error: is no option any more; --draw-calibration SEED draws errors "
                "that go together as those of a real calibration do");
          })
      ->group("");  // not listed
}

void AddOptions(CLI::App& command, SimulateArguments& a) {
  SimulationRequest& r = a.request;
  command.add_option("--out", a.out, "folder of the sequence; must not exist");
  command.add_option("--scene", r.scene, SceneNames() + ", or a scene file (YAML)")
      ->capture_default_str();
  command.add_option("--trajectory", r.trajectory, FlightNames() + ", or ground truth (csv)")
      ->capture_default_str();
  command.add_option("--imu", r.imu, "real IMU of the recorded trajectory (csv)");
  command.add_option("--calibration", r.calibration, "as for facet run; default: EuRoC's vehicle");
  command.add_option("--textures", r.textures, "folder with images for pictures and prints");
  command.add_option("--seed", r.seed, "another scene, flight and noise")
      ->check(NonNegativeNumber())
      ->capture_default_str();
  command
      .add_option("--noise-seeds",
                  a.num_noise_seeds,
                  "this many sequences OUT-1, OUT-2, ... that differ in noise only; rendered once")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command.add_option("--start", r.start_s, "seconds into a recorded trajectory")
      ->check(NonNegativeNumber());
  command.add_option("--duration", r.duration_s, "seconds (20; recorded: all)")
      ->check(PositiveNumber());
  command.add_option("--threads", r.num_threads, "any number gives the same files")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command.add_option("--set", a.overrides, "key.path=value, repeatable; keys: --list")
      ->allow_extra_args(false);
  command.add_flag("--noise-free", a.noise_free, "as --clean-images --clean-imu");
  command.add_flag("--clean-images",
                   a.clean_images,
                   "no noise, no motion blur, one exposure, 16 rays per pixel");
  command.add_flag("--clean-imu", a.clean_imu, "no noise, no vibration, no bias");
  AddCalibrationOptions(command, a);
  command
      .add_option("--fault",
                  a.faults,
                  "name:parameter=value,...: planted in the sequence of --of; repeatable; --list")
      ->allow_extra_args(false);
  command.add_option(
      "--of", a.source, "an existing sequence, to be copied with --fault or --draw-calibration");
  command.add_flag("--list", a.list, "print known scenes, flights, faults and options");
  command.add_flag("--quiet", a.quiet, "no progress bar, no summary");
}

void AddSimulate(CLI::App& app, int argc, char** argv) {
  auto* command = app.add_subcommand("simulate", "Render a stereo-inertial sequence with truth");
  auto arguments = std::make_shared<SimulateArguments>();
  arguments->request.num_threads =
      static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  arguments->command_line = "facet";
  for (int i = 1; i < argc; ++i)
    arguments->command_line += std::string(" ") + argv[i];
  AddOptions(*command, *arguments);
  command->callback([arguments] { SimulateCommand(*arguments); });
}

#else

void AddSimulate(CLI::App& app, int /*argc*/, char** /*argv*/) {
  auto* command = app.add_subcommand("simulate", "Not in this build: needs Embree 3");
  command->allow_extras();
  command->callback([] {
    throw ConfigError(
        "facet simulate is not in this build; install Embree 3 (Debian: apt install libembree-dev) "
        "and build again");
  });
}

#endif

/// CLI11 would say that a command is missing where there is one that it does not know.
bool IsUnknownCommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return false;
  const std::string name = argv[1];
  return app.get_subcommands([&](const CLI::App* c) { return c->check_name(name); }).empty();
}

}  // namespace

void RunCommandLine(int argc, char** argv) {
  CLI::App app("Facet: stereo visual-inertial odometry", "facet");
  app.set_version_flag("--version", "facet " FACET_VERSION);
  app.require_subcommand(1);
  AddRun(app);
  AddInfo(app);
  AddCheck(app);
  AddConvert(app);
  AddEvaluate(app);
  AddCompare(app);
  AddView(app);
  AddMap(app);
  AddPicture(app);
  AddConfig(app);
  AddSimulate(app, argc, argv);
  try {
    if (IsUnknownCommand(app, argc, argv))
      throw UsageError("unknown command '" + std::string(argv[1]) + "'; see facet --help");
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const auto code = static_cast<CLI::ExitCodes>(error.get_exit_code());
    if (code != CLI::ExitCodes::Success)
      throw UsageError(std::string(error.what()) + "; see facet --help");
    app.exit(error);  // prints help or version
  }
}

}  // namespace facet
