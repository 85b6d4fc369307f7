// SPDX-License-Identifier: BSD-2-Clause
// The commands of the program and their options, all in one source: CLI11 takes long to compile.
#pragma once

#include <stdexcept>

namespace facet {

/// What is wrong with a command line.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Runs the command that is given, or prints help or version. Throws UsageError and what the
/// commands throw: InputError, ConfigError, OutputError, RunEndedError.
void RunCommandLine(int argc, char** argv);

}  // namespace facet
