// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

#include "facet/render/simulator.h"

namespace facet {

/// What `facet simulate` is told on the command line.
struct SimulateArguments {
  SimulationRequest request;
  std::string out;
  std::vector<std::string> overrides;
  std::string source;               ///< sequence that is copied; empty: a scene is rendered
  std::vector<std::string> faults;  ///< planted in the copy; see PlantFault
  std::vector<std::string> drawn_parts;
  int num_noise_seeds = 1;
  bool noise_free = false, clean_images = false, clean_imu = false;
  bool list = false, quiet = false;
  std::string command_line;  ///< written beside the sequence
};

/// `facet simulate`. Throws InputError, ConfigError, OutputError or RunEndedError.
void SimulateCommand(SimulateArguments arguments);

}  // namespace facet
