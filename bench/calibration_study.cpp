// SPDX-License-Identifier: BSD-2-Clause
// calibration_study SEQUENCE [--seeds N] [--duration S] [--set key=value]...
// What errors of the calibration cost: runs pipeline S over a sequence whose calibration is right
// with calibrations that somebody might have measured (facet simulate --calibration-error), one
// kind of errors after the other, and prints the ATE.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "program.h"
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

struct ErrorKind {
  const char* name;
  CalibrationErrorOptions sizes;
};

/// Each kind alone with the sizes of `all`, then all of them.
std::vector<ErrorKind> KindsOf(const CalibrationErrorOptions& all) {
  CalibrationErrorOptions none = all;
  none.enabled = true;
  none.focal_px = none.center_px = none.radial = none.tangential = 0;
  none.rotation_deg = none.translation_m = 0;
  none.stereo_rotation_deg = none.stereo_translation_m = 0;
  std::vector<ErrorKind> kinds(8, {"", none});
  kinds[0].name = "focal lengths";
  kinds[0].sizes.focal_px = all.focal_px;
  kinds[1].name = "principal points";
  kinds[1].sizes.center_px = all.center_px;
  kinds[2].name = "distortion";
  kinds[2].sizes.radial = all.radial;
  kinds[2].sizes.tangential = all.tangential;
  kinds[3].name = "turn of both cameras";
  kinds[3].sizes.rotation_deg = all.rotation_deg;
  kinds[4].name = "place of both cameras";
  kinds[4].sizes.translation_m = all.translation_m;
  kinds[5].name = "turn between them";
  kinds[5].sizes.stereo_rotation_deg = all.stereo_rotation_deg;
  kinds[6].name = "place between them";
  kinds[6].sizes.stereo_translation_m = all.stereo_translation_m;
  kinds[7] = {"all", all};
  kinds[7].sizes.enabled = true;
  return kinds;
}

class Study {
 public:
  Study(const std::string& sequence, const VioOptions& options, double duration_s)
      : dataset_(sequence),
        truth_(ReadTrajectory(FindTruth(sequence))),
        options_(options),
        end_(dataset_.frames().front().t + FromSeconds(duration_s)) {}

  /// ATE [mm] of a run with the calibration that was measured with such errors.
  double Run(const CalibrationErrorOptions& errors, int seed) {
    const StereoRig rig = MeasureRig(dataset_.rig(), errors, static_cast<std::uint64_t>(seed));
    std::vector<StampedPose> estimate;
    const auto is_due = [&](std::size_t i, const StereoFrame&, FrontPacket&) {
      return dataset_.frames()[i].t < end_;
    };
    RunStages(dataset_, rig, options_, is_due, [&](const VioOutput& out) {
      if (out.has_pose) estimate.push_back({out.t, out.state.T_WB});
    });
    const std::string problem = WhatIsWrong(estimate, truth_.poses);
    if (!problem.empty()) throw InputError("the sequence, or --duration, is too short: " + problem);
    return 1e3 * EvaluateTrajectory(estimate, truth_.poses).ate_m.rmse;
  }

 private:
  AslDataset dataset_;
  Trajectory truth_;
  VioOptions options_;
  Timestamp end_;
};

int Main(int argc, char** argv) {
  CLI::App app("What errors of the calibration cost pipeline S");
  std::string sequence;
  std::vector<std::string> overrides;
  CalibrationErrorOptions all;
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
  std::printf("right calibration: ATE rmse %.2f mm; with errors, over %d calibrations:\n",
              right_mm,
              num_seeds);
  std::printf("  %-24s %10s %10s %10s\n", "", "median mm", "worst mm", "median / right");
  for (const ErrorKind& kind : KindsOf(all)) {
    std::vector<double> ate_mm;
    for (int seed = 1; seed <= num_seeds; ++seed)
      ate_mm.push_back(study.Run(kind.sizes, seed));
    const double worst_mm = *std::max_element(ate_mm.begin(), ate_mm.end());
    const double median_mm = *Median(ate_mm);
    std::printf(
        "  %-24s %10.2f %10.2f %10.2f\n", kind.name, median_mm, worst_mm, median_mm / right_mm);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("calibration_study", facet::Main, argc, argv);
}
