// SPDX-License-Identifier: BSD-2-Clause
// `facet simulate` without the command line: from a scene and a motion to a sequence with exact
// truth.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "facet/calibration/drawn_calibration.h"
#include "facet/render/motion.h"
#include "facet/render/simulator_options.h"
#include "facet/render/surface_truth.h"

namespace facet {

/// "room, corridor, ...", for messages.
std::string SceneNames();

struct SimulationRequest {
  std::string scene = "room";         ///< a name of SceneNames(), or a scene file
  std::string trajectory = "gentle";  ///< a name of FlightNames(), or ground truth in EuRoC's csv
  std::string imu;                    ///< EuRoC's csv of a recorded flight; empty: simulated
  std::string calibration;            ///< as for `facet run`; empty: the EuRoC vehicle
  std::string textures;               ///< folder with images; empty: procedural
  std::uint64_t seed = 1;
  double start_s = 0, duration_s = 0;
  int num_threads = 1;
  std::optional<std::uint64_t> drawn_calibration;  ///< seed; empty: the exact one is written
  DrawnParts drawn_parts;
  std::optional<std::uint64_t> lens_misfit;  ///< seed; empty: the lenses obey their model
  SimulatorOptions options;
};

struct SimulationReport {
  bool is_complete = false;  ///< false: stopped by the observer, the folder is useless
  int num_pairs = 0;
  double duration_s = 0, path_m = 0, max_speed = 0;
  double min_clearance_m = 0;
  std::size_t num_triangles = 0, num_planes = 0, num_points = 0;
  double render_wall_s = 0;  ///< of the images
  std::optional<Smoothing> smoothing;
  std::optional<ImuBias> found_bias;  ///< of a real IMU, where the record told none: FillInBiases
};

/// Called now and then from any one thread at a time with the number of finished pairs; false stops
/// the simulation.
using SimulationObserver = std::function<bool(int done, int total)>;

/// Writes the sequence into the existing folders: into each with other noise of images and IMU, all
/// else being equal and rendered once. The first folder's files are those of a request for one. The
/// files depend on the request only, not on the number of threads. Throws ConfigError for unknown
/// names, InputError for unusable files and for a path that leaves the scene or comes too near to a
/// surface, OutputError.
SimulationReport Simulate(const SimulationRequest& request,
                          std::span<const std::filesystem::path> folders,
                          const SimulationObserver& observer);

}  // namespace facet
