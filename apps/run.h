// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace CLI {
class App;
}

namespace facet {

/// A run that ended early after its results were written; carries the exit code.
class RunEndedError : public std::runtime_error {
 public:
  RunEndedError(int exit_code, const std::string& message)
      : std::runtime_error(message), exit_code_(exit_code) {}
  int exit_code() const { return exit_code_; }

 private:
  int exit_code_;
};

/// Adds `facet run`. The command throws InputError, ConfigError, OutputError or RunEndedError.
void AddRunCommand(CLI::App& app);

}  // namespace facet
