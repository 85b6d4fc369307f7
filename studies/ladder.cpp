// SPDX-License-Identifier: BSD-2-Clause
// Question: how much can planes gain, and how much of it does the search keep? The same simulated
//   features and IMU with plain S, and with planes from better and better sources (the rungs of the
//   ladder). Prints paired ratios of the trajectory error.
// Command: ladder [--seeds N] [--duration S] [--only FLIGHT,...] [--rungs KEY,...] [--jobs J]
//   [--set key=value]...
// Answer: SPR has 0.56 to 0.91 of the ATE of S, as little as with true planes and true members;
//   planes that expire after 6 s gain 3 to 5 % only (docs/notebook/planes_figures.md, "Features").
// Date: 2026-11-21 to 2026-11-23.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "bench/program.h"
#include "ladder_report.h"
#include "scaled_run.h"
#include <CLI/CLI.hpp>

#include "facet/base/stage_timer.h"
#include "facet/io/config_file.h"

namespace facet {
namespace {

struct LadderOptions {
  ConsistencyOptions consistency;
  std::vector<std::string> flights;  ///< empty: all
  double duration_s = 40;
  double scale = 1;     ///< of all lengths, accelerations included
  double budget_s = 0;  ///< no realisation of a flight begins later than this; 0: no limit
  int jobs = 1;
};

/// Realisations in parallel, each through all rungs, so that whatever is done in time is paired.
std::vector<Realisation> RunFlight(const Scenario& scenario,
                                   const LadderOptions& options,
                                   const std::vector<Rung>& rungs,
                                   OutcomeFile* file) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const auto elapsed_s = [&] {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  std::vector<Realisation> done;
  std::mutex mutex;
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next++; i < options.consistency.num_seeds; i = next++) {
      if (options.budget_s > 0 && elapsed_s() > options.budget_s) return;
      Realisation realisation;
      realisation.seed = static_cast<std::uint64_t>(options.consistency.first_seed + i);
      std::optional<SimulatedRun> run;  // simulated when the first rung needs it
      for (const Rung& rung : rungs) {
        if (file != nullptr) {
          const std::lock_guard lock(mutex);
          if (const Outcome* known = file->Find(scenario.name, realisation.seed, rung.key)) {
            realisation.outcomes.push_back(*known);
            continue;
          }
        }
        if (!run) {
          const double begin_ms = ThreadCpuMs();
          run = ScaledRun(Simulate(scenario, options.consistency, realisation.seed), options.scale);
          realisation.simulation_s = (ThreadCpuMs() - begin_ms) / 1000;
        }
        realisation.outcomes.push_back(
            RunRung(*run, ScaledOptions(options.consistency, options.scale), rung));
        const std::lock_guard lock(mutex);
        if (file != nullptr)
          file->Add(scenario.name, realisation.seed, rung.key, realisation.outcomes.back());
      }
      const std::lock_guard lock(mutex);
      done.push_back(std::move(realisation));
      std::fprintf(stderr,
                   "%s: %zu of %d realisations, %.0f s\n",
                   scenario.name.c_str(),
                   done.size(),
                   options.consistency.num_seeds,
                   elapsed_s());
    }
  };
  std::vector<std::thread> threads;
  for (int k = 0; k < options.jobs; ++k)
    threads.emplace_back(work);
  for (std::thread& thread : threads)
    thread.join();
  std::sort(done.begin(), done.end(), [](const auto& a, const auto& b) { return a.seed < b.seed; });
  return done;
}

std::vector<Scenario> SelectFlights(const LadderOptions& options) {
  std::vector<Scenario> flights = FindScenarios(options.duration_s);
  for (Scenario& corridor : CorridorScenarios(options.duration_s))
    flights.push_back(std::move(corridor));
  std::string known;
  for (const Scenario& flight : flights)
    known += (known.empty() ? "" : ", ") + flight.name;
  for (const std::string& name : options.flights) {
    if (std::none_of(flights.begin(), flights.end(), [&](const auto& f) { return f.name == name; }))
      throw std::runtime_error("no flight \"" + name + "\"; there are " + known);
  }
  if (options.flights.empty()) return flights;
  std::erase_if(flights, [&](const Scenario& flight) {
    return std::find(options.flights.begin(), options.flights.end(), flight.name) ==
           options.flights.end();
  });
  return flights;
}

int Main(int argc, char** argv) {
  CLI::App app("What planes can gain, rung by rung, on simulated features");
  LadderOptions options;
  ConsistencyOptions& consistency = options.consistency;
  consistency.num_seeds = 64;
  SearchOptions search;
  std::vector<std::string> overrides, search_overrides, rung_keys;
  std::string csv_path;
  app.add_option("--seeds", consistency.num_seeds, "realisations per flight")
      ->check(CLI::Range(1, 100000));
  app.add_option("--first-seed", consistency.first_seed, "the first of them");
  app.add_option("--duration", options.duration_s, "length of a run [s]")
      ->check(CLI::Range(5, 120));
  app.add_option("--scale", options.scale, "all lengths, and gravity, times this")
      ->check(CLI::Range(0.01, 100.0));
  app.add_option("--only", options.flights, "names of flights, with commas")->delimiter(',');
  app.add_option("--rungs", rung_keys, "keys of rungs besides S, with commas")->delimiter(',');
  app.add_option("--jobs", options.jobs, "runs at the same time")->check(CLI::Range(1, 256));
  app.add_option("--budget", options.budget_s, "begin no realisation of a flight later [s]");
  app.add_option("--csv", csv_path, "file for single outcomes; what is there is not run again");
  app.add_option("--set", overrides, "option of the estimator, key=value");
  app.add_option("--search", search_overrides, "option of the search, mesh.* or regularities.*");
  CLI11_PARSE(app, argc, argv);

  ApplyOverrides(overrides, ListFields(consistency.estimator));
  ApplyOverrides(search_overrides, ListFields(search));
  const std::vector<Rung> rungs = SelectRungs(MakeRungs(search), rung_keys);
  const std::vector<Scenario> flights = SelectFlights(options);
  std::optional<OutcomeFile> file;
  if (!csv_path.empty()) {
    std::string settings = "duration " + std::to_string(options.duration_s);
    if (options.scale != 1) settings += " scale " + std::to_string(options.scale);
    for (const std::vector<std::string>* texts : {&overrides, &search_overrides}) {
      for (const std::string& text : *texts)
        settings += " " + text;
    }
    file.emplace(csv_path, settings);
  }
  for (const Scenario& flight : flights) {
    const std::vector<Realisation> realisations =
        RunFlight(flight, options, rungs, file ? &*file : nullptr);
    if (realisations.empty()) continue;  // the budget is used up
    std::printf("%s, %.0f s, %zu realisations\n",
                flight.name.c_str(),
                flight.duration_s,
                realisations.size());
    PrintLadder(rungs, realisations);
  }
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("ladder", facet::Main, argc, argv);
}
