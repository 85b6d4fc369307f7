// SPDX-License-Identifier: BSD-2-Clause
// Question: what do errors of the calibration cost pipeline S? A sequence whose calibration is
//   right is run with calibrations that somebody might have measured (facet simulate
//   --calibration-error), with one kind of errors after the other.
// Command: calibration_study SEQUENCE [--seeds N] [--duration S] [--set key=value]...
// Answer: distortion (1.4 to 8 times the ATE) and focal lengths (1.3 to 4 times) cost most, a
//   rotation between the cameras 1.2 to 1.9 times (docs/notebook/calibration_errors.md).
// Date: 2026-11-23.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "bench/program.h"
#include "stage_run.h"
#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>

#include "facet/base/median.h"
#include "facet/eval/trajectory_error.h"
#include "facet/io/errors.h"
#include "facet/io/trajectory_file.h"
#include "facet/render/calibration_error.h"

namespace facet {
namespace {

using Errors = CalibrationErrorOptions;

struct ErrorKind {
  const char* name;
  std::vector<double Errors::*> sizes;
};

const ErrorKind kKinds[] = {
    {"focal lengths", {&Errors::focal_px}},
    {"principal points", {&Errors::center_px}},
    {"distortion", {&Errors::radial, &Errors::tangential}},
    {"turn of both cameras", {&Errors::rotation_deg}},
    {"place of both cameras", {&Errors::translation_m}},
    {"turn between them", {&Errors::stereo_rotation_deg}},
    {"place between them", {&Errors::stereo_translation_m}},
};

/// Errors of the usual sizes, but only of these kinds.
Errors Only(std::span<const ErrorKind> kinds) {
  Errors errors;
  errors.enabled = true;
  for (const ErrorKind& kind : kKinds) {
    for (const auto size : kind.sizes)
      errors.*size = 0;
  }
  for (const ErrorKind& kind : kinds) {
    for (const auto size : kind.sizes)
      errors.*size = Errors().*size;
  }
  return errors;
}

class Study {
 public:
  Study(const std::string& sequence, const VioOptions& options, double duration_s)
      : dataset_(sequence),
        truth_(ReadTrajectory(RequireTruth(sequence))),
        options_(options),
        end_(dataset_.frames().front().t + FromSeconds(duration_s)) {}

  /// ATE [mm] of a run with the calibration that was measured with such errors.
  double Run(const Errors& errors, int seed) {
    const StereoRig rig = MeasureRig(dataset_.rig(), errors, static_cast<std::uint64_t>(seed));
    std::vector<StampedPose> estimate;
    const auto is_due = [&](std::size_t i, const StereoFrame&, TrackedFrame&) {
      return dataset_.frames()[i].t < end_;
    };
    RunStages(dataset_, rig, options_, is_due, [&](const VioOutput& out) {
      if (out.has_pose) estimate.push_back({out.t, out.state.T_WB});
    });
    num_poses_ = estimate.size();
    const std::string problem = WhatIsWrong(estimate, truth_.poses);
    if (!problem.empty()) throw InputError("the sequence, or --duration, is too short: " + problem);
    return 1e3 * EvaluateTrajectory(estimate, truth_.poses).ate_m.rmse;
  }

  /// Of the last run.
  std::size_t num_poses() const { return num_poses_; }

 private:
  AslDataset dataset_;
  Trajectory truth_;
  VioOptions options_;
  Timestamp end_;
  std::size_t num_poses_ = 0;
};

int Main(int argc, char** argv) {
  CLI::App app("What errors of the calibration cost pipeline S");
  std::string sequence;
  std::vector<std::string> overrides;
  double duration_s = 1e5;
  int num_seeds = 5;
  app.add_option("sequence", sequence, "with ground truth and the right calibration")->required();
  app.add_option("--seeds", num_seeds, "calibrations of each kind")->check(CLI::Range(1, 1000));
  app.add_option("--duration", duration_s, "from the first image [s]")->check(CLI::Range(1.0, 1e5));
  app.add_option("--set", overrides, "option of the pipeline, key=value");
  CLI11_PARSE(app, argc, argv);
  if (!std::isfinite(duration_s)) throw ConfigError("--duration: not a number");
  cv::setNumThreads(1);
  Study study(sequence, OptionsOfS(overrides), duration_s);
  const double right_mm = study.Run({}, 0);
  std::printf(
      "right calibration: ATE rmse %.2f mm over %zu poses; with errors, over %d "
      "calibrations:\n",
      right_mm,
      study.num_poses(),
      num_seeds);
  std::printf("  %-24s %10s %10s %10s\n", "", "median mm", "worst mm", "median / right");
  const auto print = [&](const char* name, const Errors& errors) {
    std::vector<double> ate_mm;
    for (int seed = 1; seed <= num_seeds; ++seed)
      ate_mm.push_back(study.Run(errors, seed));
    const double worst_mm = *std::max_element(ate_mm.begin(), ate_mm.end());
    const double median_mm = *Median(ate_mm);
    std::printf("  %-24s %10.2f %10.2f %10.2f\n", name, median_mm, worst_mm, median_mm / right_mm);
    std::fflush(stdout);
  };
  for (const ErrorKind& kind : kKinds)
    print(kind.name, Only({&kind, 1}));
  print("all", Only(kKinds));
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("calibration_study", facet::Main, argc, argv);
}
