// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

namespace facet {

/// What `facet view` is told on the command line.
struct ViewArguments {
  std::vector<std::string> results;  // one or two
  std::string truth;                 // empty: none
  std::string host = "127.0.0.1";
  int port = 8470;
};

/// `facet view`: serves the page until Ctrl-C. Throws InputError or ConfigError.
void ViewCommand(const ViewArguments& arguments);

/// Returns after SIGINT, SIGTERM or SIGHUP.
void WaitForInterrupt();

}  // namespace facet
