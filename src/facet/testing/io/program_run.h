// SPDX-License-Identifier: BSD-2-Clause
// For tests: runs the built program through a shell.
#pragma once

#include <cstdlib>
#include <string>

#include <sys/wait.h>

#include "facet/testing/io/test_sequence.h"

namespace facet {

struct ProgramRun {
  int exit_code = -1;
  std::string out, err;
};

/// Runs a shell command.
inline ProgramRun RunShell(const std::string& command) {
  const TempFolder folder;
  const std::string redirected = command + " >" + (folder / "out").string() + " 2>" +
                                 (folder / "err").string() + " </dev/null";
  // The command consists of constants and temporary folders of a test.
  const int status = std::system(redirected.c_str());  // NOLINT(concurrency-mt-unsafe)
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
          ReadText(folder / "out"),
          ReadText(folder / "err")};
}

/// Runs the program that the test was built with (FACET_PROGRAM).
inline ProgramRun RunFacet(const std::string& arguments) {
  return RunShell(std::string(FACET_PROGRAM) + " " + arguments);
}

}  // namespace facet
