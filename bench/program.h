// SPDX-License-Identifier: BSD-2-Clause
// How every program here ends when something is wrong.
#pragma once

#include <cstdio>
#include <exception>

namespace facet {

/// Runs `main`; what it throws is said on stderr after the program's name, exit code 1.
inline int RunProgram(const char* name, int (*main)(int, char**), int argc, char** argv) {
  try {
    return main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
}

}  // namespace facet
