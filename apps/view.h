// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

namespace facet {

/// What `facet view` is told on the command line.
struct ViewArguments {
  std::vector<std::string> results;  // one or two
  std::string truth;                 // empty: none
  std::string recording;             // with the images; empty: none
  std::string host = "127.0.0.1";
  int port = 8470;
};

/// `facet view`: serves the page until Ctrl-C. Throws InputError or ConfigError.
void ViewCommand(const ViewArguments& arguments);

class ViewServer;

/// From 0 to 65535. Throws ConfigError, with the name of the option.
int ParsePort(const std::string& option, const std::string& text);

/// Where the page is; and if the wanted port is in use, says so.
void PrintAddress(const ViewServer& server, int wanted_port);

/// Returns after SIGINT, SIGTERM or SIGHUP.
void WaitForInterrupt();

}  // namespace facet
