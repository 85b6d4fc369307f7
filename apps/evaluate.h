// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

namespace facet {

/// What `facet evaluate` is told on the command line.
struct EvaluateArguments {
  std::string result;
  std::string truth;
  std::vector<std::string> against;
  std::vector<double> rpe_lengths_m;
  std::string alignment = "se3";
  std::vector<std::string> parts = {"mesh", "planes", "consistency"};
  bool parts_are_named = false;
  bool align_time = false;
  std::string report;
};

/// `facet evaluate`. Throws InputError, ConfigError or OutputError.
void EvaluateCommand(const EvaluateArguments& arguments);

}  // namespace facet
