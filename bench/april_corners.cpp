// SPDX-License-Identifier: BSD-2-Clause
// The back end alone on EuRoC's calibration recording: trajectory, landmarks and cost; `--help`
// lists the options.
#include <cstdio>
#include <string>
#include <vector>

#include "april_corners_study.h"
#include "program.h"
#include <CLI/CLI.hpp>

#include "facet/eval/paired_comparison.h"
#include "facet/io/config_file.h"
#include "facet/io/errors.h"
#include "facet/testing/data_dir.h"

namespace facet {
namespace {

struct WindowSetting {
  int full, pose;
};
constexpr WindowSetting kWindowSettings[] = {{3, 7}, {3, 12}, {5, 10}, {8, 7}, {25, 0}};

void PrintCost(const char* name, const CostSummary& cost) {
  std::printf("CPU per %-9s       mean %.3f, median %.3f, p99 %.3f ms\n",
              name,
              cost.mean_ms,
              cost.median_ms,
              cost.p99_ms);
}

void PrintRun(const AprilRun& run, const AprilFigures& figures) {
  const ErrorStatistics& ate = figures.trajectory.ate_m;
  const ErrorStatistics& rotation = figures.rotation_deg;
  std::printf("frames                  %d\n", run.num_frames);
  std::printf("resets                  %d\n", run.num_resets);
  std::printf("coverage                %.1f %%\n", 100 * figures.coverage);
  std::printf("ATE                     rmse %.4f, median %.4f, max %.4f m\n",
              ate.rmse,
              ate.median,
              ate.max);
  std::printf("scale error             %+.3f %%\n",
              figures.trajectory.scale_error_percent.value_or(0));
  std::printf(
      "rotation error          rmse %.3f, median %.3f deg\n", rotation.rmse, rotation.median);
  std::printf("landmarks from corners  %.2f mm rms (median of %zu snapshots)\n",
              1000 * figures.landmark_rms_m,
              run.fits.size());
  std::printf("landmarks from a plane  %.2f mm rms (median)\n", 1000 * figures.flatness_m);
  if (!run.planes_W.empty()) {
    std::printf("planes against board    rmse %.3f, median %.3f, max %.3f deg\n",
                figures.plane_angle_deg.rmse,
                figures.plane_angle_deg.median,
                figures.plane_angle_deg.max);
  }
  PrintCost("frame", run.cost.all);
  PrintCost("keyframe", run.cost.keyframes);
}

void PrintWindowTable(const AprilRecording& recording, AprilOptions options) {
  std::printf(
      "| full + pose keyframes | ATE rmse / median [mm] | landmarks [mm] | back end per frame "
      "[ms] | per keyframe [ms] | resets |\n|---|---|---|---|---|---|\n");
  for (const WindowSetting& setting : kWindowSettings) {
    options.estimator.window.max_full_keyframes = setting.full;
    options.estimator.window.max_pose_keyframes = setting.pose;
    const AprilRun run = RunAprilCorners(recording, options);
    const AprilFigures figures = EvaluateAprilCorners(recording, run);
    std::printf("| %d + %d | %.1f / %.1f | %.2f | %.2f | %.2f | %d |\n",
                setting.full,
                setting.pose,
                1000 * figures.trajectory.ate_m.rmse,
                1000 * figures.trajectory.ate_m.median,
                1000 * figures.landmark_rms_m,
                run.cost.all.mean_ms,
                run.cost.keyframes.mean_ms,
                run.num_resets);
    std::fflush(stdout);
  }
}

// With planes and without, begun at different times.
void PrintStarts(const AprilRecording& recording, AprilOptions options, int num_starts) {
  constexpr double kStep_s = 0.15;
  const int num_planes = options.num_planes;
  struct Column {
    std::vector<double> with, without, ratios;
  } rmse, median;
  std::vector<double> normals_deg;
  for (int k = 0; k < num_starts; ++k) {
    options.start_s = kStep_s * k;
    const auto run = [&](int planes) {
      options.num_planes = planes;
      return EvaluateAprilCorners(recording, RunAprilCorners(recording, options));
    };
    const AprilFigures with = run(num_planes), without = run(0);
    const auto add = [](double a, double b, Column& column) {
      column.with.push_back(1000 * a);
      column.without.push_back(1000 * b);
      column.ratios.push_back(a / b);
    };
    add(with.trajectory.ate_m.rmse, without.trajectory.ate_m.rmse, rmse);
    add(with.trajectory.ate_m.median, without.trajectory.ate_m.median, median);
    normals_deg.push_back(with.plane_angle_deg.median);
  }
  std::printf("%d starts, medians\n", num_starts);
  const auto print = [](const char* name, const Column& column) {
    const PairedComparison ratio = CompareRatios(column.ratios);
    std::printf("ATE %-19s %.2f mm, without planes %.2f; ratio %.3f [%.3f, %.3f], %d better\n",
                name,
                Summarize(column.with).median,
                Summarize(column.without).median,
                ratio.median_ratio,
                ratio.low,
                ratio.high,
                ratio.num_better);
  };
  print("rmse", rmse);
  print("median", median);
  std::printf("planes against board    %.3f deg\n", Summarize(normals_deg).median);
}

std::filesystem::path Find(const std::string& name) {
  const auto folder = testing::DataDir(name);
  if (!folder) throw InputError(testing::MissingData(name));
  return *folder;
}

int Main(int argc, char** argv) {
  CLI::App app("The back end alone on EuRoC's calibration recording");
  AprilOptions options;
  std::vector<std::string> overrides;
  bool window_table = false;
  int num_starts = 0;
  std::string output;
  app.add_option("--set", overrides, "option of the estimator, key=value");
  app.add_option("--keyframe-every", options.keyframe_every, "frames per keyframe")
      ->check(CLI::Range(1, 100));
  app.add_option("--pixel-sigma", options.pixel_sigma, "1-sigma of the corners [px]")
      ->check(CLI::Range(0.01, 100.0));
  const auto planes =
      app.add_option("--planes", options.num_planes, "0: none, 1: the board, 4: its quarters")
          ->check(CLI::IsMember({0, 1, 4}));
  const auto start =
      app.add_option("--start", options.start_s, "begin so long into the recording [s]")
          ->check(CLI::Range(0.0, 60.0));
  app.add_flag("--hide", options.hide_quarters, "hide each quarter of the board for 8 s");
  const auto table =
      app.add_flag("--window-table", window_table, "compare window sizes (markdown)");
  const auto file =
      app.add_option("--output", output, "file for the causal trajectory (TUM)")->excludes(table);
  app.add_option("--starts", num_starts, "so many starts, each with the planes and without")
      ->check(CLI::Range(1, 100))
      ->needs(planes)
      ->excludes(start)
      ->excludes(table)
      ->excludes(file);
  CLI11_PARSE(app, argc, argv);

  ApplyOverrides(overrides, ListFields(options.estimator));
  const AprilRecording recording =
      LoadAprilRecording(Find("euroc_april_corners"), Find("euroc_mh01_handheld/mav0"));
  if (window_table) {
    PrintWindowTable(recording, options);
    return 0;
  }
  if (num_starts > 0) {
    PrintStarts(recording, options, num_starts);
    return 0;
  }
  const AprilRun run = RunAprilCorners(recording, options);
  PrintRun(run, EvaluateAprilCorners(recording, run));
  if (!output.empty()) WriteTum(output, run.poses);
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("april_corners", facet::Main, argc, argv);
}
