// SPDX-License-Identifier: BSD-2-Clause
// ladder [--seeds N] [--duration S] [--set key=value]...
// What planes can gain, rung by rung: the same simulated features and IMU with plain S, and with
// planes from better and better oracles. Prints paired ratios of the trajectory error.
#include <atomic>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "consistency_study.h"
#include "ladder_planes.h"
#include <CLI/CLI.hpp>

#include "facet/eval/paired_comparison.h"
#include "facet/eval/trajectory_error.h"
#include "facet/io/config_file.h"

namespace facet {
namespace {

struct Rung {
  std::string name;
  std::function<PlanePolicy(const SimulatedRun&, SearchQuality&)> make;  ///< empty: no planes
};

/// Options of the search; the estimator's come with ConsistencyOptions.
struct SearchOptions {
  MeshOptions mesh;
  RegularityOptions regularities;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Group("mesh", mesh);
    v.Group("regularities", regularities);
  }
};

std::vector<Rung> MakeRungs(const SearchOptions& search) {
  const auto oracle = [](double max_age_s) {
    return [max_age_s](const SimulatedRun& run, SearchQuality& /*quality*/) -> PlanePolicy {
      OraclePlaneOptions options;
      options.max_age_s = max_age_s;
      return OraclePlanes(run, options);
    };
  };
  const auto own = [](const SearchOptions& options) {
    return [options](const SimulatedRun& run, SearchQuality& quality) -> PlanePolicy {
      const auto policy =
          std::make_shared<OwnSearch>(run, options.mesh, options.regularities, quality);
      return [policy](const FrameObservations& observations, const MapSnapshot& snapshot) {
        return (*policy)(observations, snapshot);
      };
    };
  };
  SearchOptions unrelated = search, short_lived = search;
  unrelated.regularities.relations.enabled = false;
  short_lived.regularities.tracking.max_age_s = 6;
  const auto spoiled = [&](const SearchOptions& options) {
    return [make = own(options)](const SimulatedRun& run, SearchQuality& quality) -> PlanePolicy {
      constexpr double kFrom_s = 15;
      return SpoiledPlanes(make(run, quality), kFrom_s);
    };
  };
  const auto placebo = [](const SimulatedRun& run, SearchQuality& /*quality*/) -> PlanePolicy {
    return PlaceboPlanes(run);
  };
  return {{"S", nullptr},
          {"true planes, kept", oracle(0)},
          {"true planes, 6 s", oracle(6.0)},
          {"SPR", own(search)},
          {"SPR, no relations", own(unrelated)},
          {"SPR, 6 s", own(short_lived)},
          {"SPR, 20 % wrong for 1 s", spoiled(search)},
          {"placebo, shuffled", placebo}};
}

struct Outcome {
  double ate_m = 0;
  double pose_nees = 0, yaw_nees = 0;  ///< over their degrees of freedom, mean over the frames
  int num_resets = 0;
  SearchQuality quality;
};

Outcome RunRung(const SimulatedRun& run, const ConsistencyOptions& options, const Rung& rung) {
  Outcome out;
  const PlanePolicy planes = rung.make ? rung.make(run, out.quality) : nullptr;
  const ConsistencyRun result = RunConsistency(run, options, false, planes);
  const KeyframeTrajectories& keyframes = result.keyframes;
  out.ate_m = EvaluateTrajectory(keyframes.causal, keyframes.truth).ate_m.rmse;
  out.num_resets = result.num_resets;
  for (const FrameError& frame : result.frames) {
    out.pose_nees += ComputeNeesRatios(frame)[static_cast<std::size_t>(StatePart::kPose)];
    const Vector3d axis_B = frame.R_WB.transpose() * Vector3d::UnitZ();
    const double yaw = axis_B.dot(frame.error.head<3>());
    out.yaw_nees += yaw * yaw / axis_B.dot(frame.covariance.topLeftCorner<3, 3>() * axis_B);
  }
  out.pose_nees /= static_cast<double>(result.frames.size());
  out.yaw_nees /= static_cast<double>(result.frames.size());
  return out;
}

// Median of the ratios with its 95 % interval (bootstrap).
void PrintRatio(const char* name,
                const std::vector<Outcome>& outcomes,
                const std::vector<Outcome>& base) {
  double ate = 0, pose_nees = 0, yaw_nees = 0;
  std::vector<double> ratios;
  int resets = 0;
  SearchQuality quality;
  const double n = static_cast<double>(outcomes.size());
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    ratios.push_back(outcomes[i].ate_m / base[i].ate_m);
    ate += outcomes[i].ate_m;
    pose_nees += outcomes[i].pose_nees;
    yaw_nees += outcomes[i].yaw_nees;
    resets += outcomes[i].num_resets;
    quality.num_created += outcomes[i].quality.num_created;
    quality.num_joined += outcomes[i].quality.num_joined;
    quality.num_wrong += outcomes[i].quality.num_wrong;
  }
  const PairedComparison comparison = CompareRatios(std::move(ratios));
  std::printf(
      "  %-24s ATE %.4f m   ratio %.3f [%.3f, %.3f]   NEES pose %.2f yaw %.2f   "
      "resets %d\n",
      name,
      ate / n,
      comparison.median_ratio,
      comparison.low,
      comparison.high,
      pose_nees / n,
      yaw_nees / n,
      resets);
  if (quality.num_joined > 0) {
    std::printf("  %-24s planes %.1f   landmarks joined %.0f   of them wrongly %.1f %%\n",
                "",
                quality.num_created / n,
                quality.num_joined / n,
                100.0 * quality.num_wrong / quality.num_joined);
  }
}

void RunLadder(const Scenario& scenario,
               const ConsistencyOptions& options,
               const std::vector<Rung>& rungs,
               int jobs) {
  const auto seeds = static_cast<std::size_t>(options.num_seeds);
  std::vector<std::vector<Outcome>> outcomes(rungs.size(), std::vector<Outcome>(seeds));
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < seeds; i = next++) {
      const std::uint64_t seed = static_cast<std::uint64_t>(options.first_seed) + i;
      const SimulatedRun run = Simulate(scenario, options, seed);
      for (std::size_t r = 0; r < rungs.size(); ++r)
        outcomes[r][i] = RunRung(run, options, rungs[r]);
    }
  };
  std::vector<std::thread> threads;
  for (int k = 0; k < jobs; ++k)
    threads.emplace_back(work);
  for (std::thread& thread : threads)
    thread.join();
  std::printf("%s, %.0f s, %zu realisations\n", scenario.name.c_str(), scenario.duration_s, seeds);
  for (std::size_t r = 0; r < rungs.size(); ++r)
    PrintRatio(rungs[r].name.c_str(), outcomes[r], outcomes[0]);
}

int Main(int argc, char** argv) {
  CLI::App app("What planes can gain, rung by rung, on simulated features");
  ConsistencyOptions options;
  options.num_seeds = 64;
  SearchOptions search;
  std::vector<std::string> overrides, search_overrides;
  std::string only;
  double duration_s = 40;
  int jobs = 1;
  app.add_option("--seeds", options.num_seeds, "realisations per flight")
      ->check(CLI::Range(2, 100000));
  app.add_option("--first-seed", options.first_seed, "the first of them");
  app.add_option("--duration", duration_s, "length of a run [s]")->check(CLI::Range(5, 60));
  app.add_option("--only", only, "name of one flight");
  app.add_option("--jobs", jobs, "runs at the same time")->check(CLI::Range(1, 256));
  app.add_option("--set", overrides, "option of the estimator, key=value");
  app.add_option("--search", search_overrides, "option of the search, mesh.* or regularities.*");
  CLI11_PARSE(app, argc, argv);

  ApplyOverrides(overrides, ListFields(options.estimator));
  ApplyOverrides(search_overrides, ListFields(search));
  for (const Scenario& scenario : FindScenarios(duration_s)) {
    if (only.empty() || scenario.name == only)
      RunLadder(scenario, options, MakeRungs(search), jobs);
  }
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  try {
    return facet::Main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ladder: %s\n", error.what());
    return 1;
  }
}
