// SPDX-License-Identifier: BSD-2-Clause
// Simulated flights for the consistency study: real trajectories, exact truth, and noise that is
// exactly what the estimator assumes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "facet/estimator/estimator_options.h"
#include "facet/sim/feature_simulator.h"

namespace facet {

/// A stretch of a flight.
struct Scenario {
  std::string name;
  SplineTrajectory trajectory;
  double start_s = 0;
  double duration_s = 0;
  std::optional<CorridorOptions> corridor;  ///< otherwise a room around the flight
};

/// Stretches in motion of three EuRoC flights; `folder` is euroc_flights. Throws
/// std::runtime_error when a file is missing.
std::vector<Scenario> RecordedScenarios(const std::filesystem::path& folder, double duration_s);

/// Made-up flights, for machines without the recordings.
std::vector<Scenario> MadeUpScenarios(double duration_s);

/// Walks around a corridor, which is seen again after 26 m: with cupboards, and with panels 10 cm
/// before the walls.
std::vector<Scenario> CorridorScenarios(double duration_s);

/// Minutes in one place of a room: hovering, which wanders by a decimetre, and set down after ten
/// seconds of that.
std::vector<Scenario> HoverScenarios(double duration_s);

/// The recorded flights if they are there, otherwise the made-up ones, with a word on stderr.
std::vector<Scenario> FindScenarios(double duration_s);

struct ConsistencyOptions {
  ConsistencyOptions();

  EstimatorOptions estimator;  ///< IMU scales 1, axes exact, origin known to 0.1 mm
  FeatureSimulatorOptions simulator;
  int num_seeds = 50;
  int first_seed = 1;
  int batch_seeds = 10;  ///< the first of the seeds are also solved as one batch
  int batch_iterations = 15;
  bool align_at_first_output = false;  ///< otherwise where the estimator fixes its origin
};

SimulatedRun Simulate(const Scenario& scenario,
                      const ConsistencyOptions& options,
                      std::uint64_t seed);

}  // namespace facet
