// SPDX-License-Identifier: BSD-2-Clause
// live_state [--seeds N] [--latency S] [--set key=value]...
// The state at the rate of the IMU against the truth of simulated flights, and what a call costs.
#include <string>
#include <vector>

#include "live_state_study.h"
#include "program.h"
#include <CLI/CLI.hpp>

#include "facet/io/config_file.h"

namespace facet {
namespace {

int Main(int argc, char** argv) {
  CLI::App app("The state at the rate of the IMU against the truth of simulated flights");
  LiveStateOptions options;
  std::vector<std::string> overrides;
  std::string only;
  double duration_s = 18;
  options.consistency.num_seeds = 10;
  app.add_option("--seeds", options.consistency.num_seeds, "runs per flight")
      ->check(CLI::Range(1, 100000));
  app.add_option("--duration", duration_s, "length of a run [s]")->check(CLI::Range(3, 60));
  app.add_option("--latency", options.latency_s, "from exposure to state [s]")
      ->check(CLI::Range(0.0, 0.5));
  app.add_option("--after", options.ask_after_s, "from a sample to the question [s]")
      ->check(CLI::Range(0.0, 0.5));
  app.add_option("--smoothing", options.smoothing_s, "of the smoothed variant [s]")
      ->check(CLI::Range(0.001, 10.0));
  app.add_option("--only", only, "name of one flight");
  app.add_option("--set", overrides, "option of the estimator, key=value");
  CLI11_PARSE(app, argc, argv);
  ApplyOverrides(overrides, ListFields(options.consistency.estimator));
  for (const Scenario& scenario : FindScenarios(duration_s)) {
    if (only.empty() || scenario.name == only) PrintFigures(StudyLiveState(scenario, options));
  }
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("live_state", facet::Main, argc, argv);
}
