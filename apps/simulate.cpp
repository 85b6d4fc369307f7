// SPDX-License-Identifier: BSD-2-Clause
// `facet simulate`: a sequence with exact truth.
#include "simulate.h"

#include <CLI/CLI.hpp>

#include "facet/io/errors.h"

#ifdef FACET_HAS_SIMULATOR

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "number_check.h"
#include "progress_bar.h"
#include "run.h"

#include "facet/io/config_file.h"
#include "facet/io/result_folder.h"
#include "facet/io/text_file.h"
#include "facet/render/sequence_writer.h"
#include "facet/render/simulator.h"

namespace facet {
namespace {

struct SimulateArguments {
  SimulationRequest request;
  std::string out;
  std::vector<std::string> overrides;
  int num_noise_seeds = 1;
  bool noise_free = false, clean_images = false, clean_imu = false, calibration_error = false;
  bool list = false, quiet = false;
  std::string command_line;
};

volatile std::sig_atomic_t interrupted = 0;

void CatchInterrupts() {
  struct sigaction action {};
  action.sa_handler = [](int) { interrupted = 1; };
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error like a full disk
}

/// Everything in the images but geometry, light and texture.
void CleanImages(SimulatorOptions& options) {
  options.sensor.add_noise = false;
  options.image.motion_blur = false;
  options.image.auto_exposure = false;
  options.image.right_gain = 0;
  options.image.rays_per_pixel = 16;  // with few rays the borders of surfaces are noisy
}

void CleanImu(SimulatorOptions& options) {
  options.imu.add_noise = false;
  options.imu.add_bias = false;
}

void ApplyOptions(SimulateArguments& a) {
  SimulatorOptions& options = a.request.options;
  if (a.noise_free || a.clean_images) CleanImages(options);
  if (a.noise_free || a.clean_imu) CleanImu(options);
  options.calibration.enabled = a.calibration_error;
  ApplyOverrides(a.overrides, ListFields(options));
  if (a.num_noise_seeds > 1 && !options.sensor.add_noise && !options.imu.add_noise) {
    throw ConfigError("--noise-seeds " + std::to_string(a.num_noise_seeds) +
                      ": without noise all sequences are the same");
  }
}

/// One folder for each noise realisation: OUT, or OUT-1, OUT-2, ...
std::vector<std::string> ListOutputs(const SimulateArguments& a) {
  if (a.out.empty()) throw ConfigError("--out DIR is required: where the sequence is written");
  if (a.num_noise_seeds == 1) return {a.out};
  std::string stem = a.out;
  while (stem.size() > 1 && stem.back() == '/')
    stem.pop_back();
  std::vector<std::string> outputs;
  for (int i = 1; i <= a.num_noise_seeds; ++i)
    outputs.push_back(stem + "-" + std::to_string(i));
  return outputs;
}

void CheckOut(const std::string& out) {
  std::error_code error;
  if (!std::filesystem::exists(out, error)) return;
  if (std::filesystem::is_directory(out, error) && std::filesystem::is_empty(out, error)) return;
  throw ConfigError("--out " + out + ": exists already; delete it or choose another name");
}

/// The text file that says where a sequence comes from and how to make it again.
std::string Describe(SimulateArguments& a, std::size_t index) {
  const std::string realisation = a.num_noise_seeds > 1
                                      ? "Noise realisation " + std::to_string(index + 1) + " of " +
                                            std::to_string(a.num_noise_seeds) + ".\n\n"
                                      : "";
  return "Simulated by Facet " FACET_VERSION
         ". The same program on the same kind of machine makes the same files with\n\n  " +
         a.command_line + "\n\n" + realisation + "Options in force (--set changes them):\n\n" +
         FormatConfig(ListFields(a.request.options));
}

void PrintFoundBias(const ImuBias& bias) {
  std::printf("the ground truth lacks biases; constants that fit were taken:");
  const auto print = [](const char* name, const Vector3d& b, const char* unit) {
    if (b.allFinite()) std::printf(" %s %.4f %.4f %.4f %s", name, b.x(), b.y(), b.z(), unit);
  };
  print("gyroscope", bias.b_g, "rad/s");
  print("accelerometer", bias.b_a, "m/s^2");
  std::printf("\n");
}

void PrintOutcome(const SimulationReport& report,
                  const std::vector<std::unique_ptr<ResultFolder>>& folders) {
  std::printf("%d stereo pairs, %.1f s, %.1f m of path, up to %.2f m/s, nearest surface %.2f m\n",
              report.num_pairs,
              report.duration_s,
              report.path_m,
              report.max_speed,
              report.min_clearance_m);
  std::printf("scene: %zu triangles, %zu planes, %zu surface points seen; %.1f pairs/s\n",
              report.num_triangles,
              report.num_planes,
              report.num_points,
              report.num_pairs / std::max(1e-3, report.render_wall_s));
  if (report.smoothing) {
    std::printf("the smoothed path moved by %.1f mm rms, %.1f mm max; %.3f deg rms, %.3f deg max\n",
                1e3 * report.smoothing->position_rms_m,
                1e3 * report.smoothing->position_max_m,
                report.smoothing->rotation_rms_deg,
                report.smoothing->rotation_max_deg);
    if (report.smoothing->tilt_deg > 0) {
      std::printf("then all of it was turned by %.3f deg, to the vertical that the IMU feels\n",
                  report.smoothing->tilt_deg);
    }
  }
  if (report.found_bias) PrintFoundBias(*report.found_bias);
  for (const auto& folder : folders)
    std::printf("written: %s\n", folder->target().c_str());
}

void RunSimulation(SimulateArguments& a) {
  if (a.list) {
    SimulatorOptions defaults;
    std::printf("scenes: room, corridor, clutter, or a scene file\nflights: %s\n\n%s",
                FlightNames().c_str(),
                FormatConfig(ListFields(defaults)).c_str());
    return;
  }
  const std::vector<std::string> outputs = ListOutputs(a);
  for (const std::string& out : outputs)
    CheckOut(out);
  ApplyOptions(a);
  CatchInterrupts();
  std::vector<std::unique_ptr<ResultFolder>> folders;
  std::vector<std::filesystem::path> stagings;
  for (const std::string& out : outputs) {
    folders.push_back(std::make_unique<ResultFolder>(out));
    stagings.push_back(folders.back()->staging());
    WriteTextFile(stagings.back() / "simulation.txt", Describe(a, stagings.size() - 1));
  }
  ProgressBar bar(!a.quiet);
  const SimulationReport report = Simulate(a.request, stagings, [&](int done, int total) {
    bar.Update(done, total, "stereo pairs");
    return interrupted == 0;
  });
  bar.Clear();
  if (!report.is_complete) {
    throw RunEndedError(128 + SIGINT, "interrupted; nothing was written");
  }
  for (const auto& folder : folders)
    folder->Commit();
  if (!a.quiet) PrintOutcome(report, folders);
}

void AddOptions(CLI::App& command, SimulateArguments& a) {
  SimulationRequest& r = a.request;
  command.add_option("--out", a.out, "folder of the sequence; must not exist");
  command.add_option("--scene", r.scene, "room, corridor, clutter, or a scene file (YAML)")
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
  command.add_flag("--calibration-error",
                   a.calibration_error,
                   "the written calibration has errors like a real one; truth/ has the exact one");
  command.add_flag("--list", a.list, "print known scenes, flights and options");
  command.add_flag("--quiet", a.quiet, "no progress bar, no summary");
}

}  // namespace

void AddSimulateCommand(CLI::App& app, int argc, char** argv) {
  auto* command = app.add_subcommand("simulate", "Render a stereo-inertial sequence with truth");
  auto arguments = std::make_shared<SimulateArguments>();
  arguments->request.num_threads =
      static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  arguments->command_line = "facet";
  for (int i = 1; i < argc; ++i)
    arguments->command_line += std::string(" ") + argv[i];
  AddOptions(*command, *arguments);
  command->callback([arguments] { RunSimulation(*arguments); });
}

}  // namespace facet

#else

namespace facet {

void AddSimulateCommand(CLI::App& app, int /*argc*/, char** /*argv*/) {
  auto* command = app.add_subcommand("simulate", "Not in this build: needs Embree 3");
  command->allow_extras();
  command->callback([] {
    throw ConfigError(
        "facet simulate is not in this build; install Embree 3 (Debian: apt install libembree-dev) "
        "and build again");
  });
}

}  // namespace facet

#endif
