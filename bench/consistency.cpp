// SPDX-License-Identifier: BSD-2-Clause
// consistency [--seeds N] [--set key=value]...
// Monte Carlo of the back end on simulated features along real flights.
#include <cstdio>
#include <string>
#include <vector>

#include "consistency_study.h"
#include "program.h"
#include <CLI/CLI.hpp>

#include "facet/io/config_file.h"

namespace facet {
namespace {

int Main(int argc, char** argv) {
  CLI::App app("Monte Carlo of the back end on simulated features along real flights");
  ConsistencyOptions options;
  std::vector<std::string> overrides;
  std::string only;
  double duration_s = 18, imu_noise_scale = 1;
  app.add_option("--seeds", options.num_seeds, "runs per flight")->check(CLI::Range(1, 100000));
  app.add_option("--first-seed", options.first_seed, "the first of them");
  app.add_option("--batch-seeds", options.batch_seeds, "runs that are also solved as one batch");
  app.add_option("--duration", duration_s, "length of a run [s]")->check(CLI::Range(3, 60));
  app.add_option("--only", only, "name of one flight");
  app.add_option("--imu-noise", imu_noise_scale, "times the datasheet, simulated and assumed");
  app.add_option("--track-life", options.simulator.mean_track_life_s, "mean, in seconds");
  app.add_option("--keyframe-every", options.simulator.keyframe_every, "frames per keyframe");
  app.add_flag("--first-output", options.align_at_first_output, "align there, not at the origin");
  app.add_option("--set", overrides, "option of the estimator, key=value");
  CLI11_PARSE(app, argc, argv);

  ApplyOverrides(overrides, ListFields(options.estimator));
  options.simulator.imu.noise.gyro_noise *= imu_noise_scale;
  options.simulator.imu.noise.accel_noise *= imu_noise_scale;
  for (const Scenario& scenario : FindScenarios(duration_s)) {
    if (only.empty() || scenario.name == only) PrintFigures(StudyConsistency(scenario, options));
  }
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("consistency", facet::Main, argc, argv);
}
