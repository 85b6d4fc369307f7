// SPDX-License-Identifier: BSD-2-Clause
// What can be wrong with the files a user gives us. Every message names the file (and line) and
// says what to do. apps/main.cpp turns each class into its exit code.
#pragma once

#include <stdexcept>

namespace facet {

/// Input missing or damaged beyond use (exit code 3).
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Wrong usage or configuration (exit code 2).
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A result could not be written: disk full, no permission (exit code 5).
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace facet
