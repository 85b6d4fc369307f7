// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

namespace facet {

/// What `facet config` is told on the command line.
struct ConfigArguments {
  std::string file;
  std::vector<std::string> overrides;
  bool all = false;
};

/// `facet config`. Throws ConfigError or OutputError.
void ConfigCommand(const ConfigArguments& arguments);

}  // namespace facet
