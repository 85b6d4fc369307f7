// SPDX-License-Identifier: BSD-2-Clause
// Checks of numbers on the command line that say in a few words what is wrong (CLI11's own ones
// print the largest number there is).
#pragma once

#include <cmath>
#include <string>

#include <CLI/CLI.hpp>

namespace facet {

inline CLI::Validator NumberCheck(bool may_be_zero) {
  const auto check = [may_be_zero](const std::string& text) {
    double value = 0;
    const bool is_number = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
    if (is_number && (value > 0 || (may_be_zero && value == 0))) return std::string();
    return "'" + text + "' is not a " + (may_be_zero ? "number of at least 0" : "positive number");
  };
  return {check, may_be_zero ? "NUMBER >= 0" : "NUMBER > 0"};
}

inline CLI::Validator PositiveNumber() {
  return NumberCheck(false);
}

inline CLI::Validator NonNegativeNumber() {
  return NumberCheck(true);
}

}  // namespace facet
