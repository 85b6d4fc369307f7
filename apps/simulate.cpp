// SPDX-License-Identifier: BSD-2-Clause
// `facet simulate`: a sequence with exact truth.
#include "simulate.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string_view>

#include "interrupts.h"
#include "progress_bar.h"
#include "run.h"

#include "facet/faults/fault.h"
#include "facet/io/config_file.h"
#include "facet/io/errors.h"
#include "facet/io/result_folder.h"
#include "facet/io/text_file.h"
#include "facet/render/calibration_draw.h"
#include "facet/render/sequence_writer.h"

namespace facet {
namespace {

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

struct NamedPart {
  std::string_view name;
  bool DrawnParts::*member;
};
constexpr NamedPart kParts[] = {{"lens", &DrawnParts::lens},
                                {"imu", &DrawnParts::imu},
                                {"time", &DrawnParts::time},
                                {"scale", &DrawnParts::scale}};

/// Empty: all of them.
DrawnParts PartsFromText(const std::vector<std::string>& names) {
  if (names.empty()) return {};
  DrawnParts parts{false, false, false, false};
  for (const std::string& name : names) {
    const auto part = std::ranges::find(kParts, name, &NamedPart::name);
    if (part == std::end(kParts))
      throw ConfigError("--draw-parts " + name + ": no such part; known: lens, imu, time, scale");
    parts.*part->member = true;
  }
  return parts;
}

void ApplyOptions(SimulateArguments& a) {
  SimulatorOptions& options = a.request.options;
  if (a.noise_free || a.clean_images) CleanImages(options);
  if (a.noise_free || a.clean_imu) CleanImu(options);
  a.request.drawn_parts = PartsFromText(a.drawn_parts);
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

/// A copy of an existing sequence with faults in it, or with another calibration.
void CopySequence(SimulateArguments& a) {
  const SimulationRequest& request = a.request;
  if (a.source.empty())
    throw ConfigError("--fault needs --of SEQUENCE: the sequence that it is planted in");
  if (a.faults.empty() && !request.drawn_calibration)
    throw ConfigError(
        "--of needs --fault: what to plant (--list names them); or --draw-calibration SEED");
  if (request.lens_misfit) throw ConfigError("--lens-misfit: nothing is rendered with --of");
  if (a.out.empty()) throw ConfigError("--out DIR is required: where the sequence is written");
  CheckOut(a.out);
  ApplyOptions(a);
  RecordingCopy recording = ReadRecording(a.source);
  if (request.drawn_calibration) {
    const CalibrationDraw draw{
        request.drawn_calibration, request.drawn_parts, request.options.calibration};
    recording.rig = WrittenCalibration(recording.exact_rig, draw);
    // Another person's calibration of an IMU that has errors already is of the same IMU.
    const auto imu_errors = UnknownImuErrors(draw);
    if (imu_errors && !recording.imu_errors) AddImuErrors(*imu_errors, recording);
  }
  for (const std::string& fault : a.faults)
    PlantFault(fault, recording);
  ResultFolder folder(a.out);
  WriteRecording(recording, folder.staging());
  WriteTextFile(folder.staging() / "simulation.txt",
                "Made by Facet " FACET_VERSION " with\n\n  " + a.command_line + "\n");
  folder.Commit();
  if (!a.quiet) std::printf("written: %s\n", folder.target().c_str());
}

}  // namespace

void SimulateCommand(SimulateArguments a) {
  if (a.list) {
    SimulatorOptions defaults;
    std::printf("scenes: %s, or a scene file\nflights: %s\nfaults:\n%s\n%s",
                SceneNames().c_str(),
                FlightNames().c_str(),
                ListFaults().c_str(),
                FormatConfig(ListFields(defaults)).c_str());
    return;
  }
  if (!a.faults.empty() || !a.source.empty()) return CopySequence(a);
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
    return !WasInterrupted();
  });
  bar.Clear();
  if (!report.is_complete) {
    throw RunEndedError(128 + SIGINT, "interrupted; nothing was written");
  }
  for (const auto& folder : folders)
    folder->Commit();
  if (!a.quiet) PrintOutcome(report, folders);
}

}  // namespace facet
