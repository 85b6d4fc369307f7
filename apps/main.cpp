// SPDX-License-Identifier: BSD-2-Clause
// The facet program: one exit code per kind of failure.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>

#include "command_line.h"
#include "run.h"
#include <opencv2/core.hpp>

#include "facet/io/errors.h"

namespace {

enum ExitCode { kDone = 0, kInternal = 1, kUsage = 2, kInput = 3, kOutput = 5 };

int Fail(int code, std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::cerr << "facet: error: " << message << std::endl;
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error like a full disk
  try {
    facet::RunCommandLine(argc, argv);
    std::cout.flush();
    if (!std::cout || std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      throw facet::OutputError("standard output cannot be written (disk full?)");
    return kDone;
  } catch (const facet::UsageError& error) {
    return Fail(kUsage, error.what());
  } catch (const facet::ConfigError& error) {
    return Fail(kUsage, error.what());
  } catch (const facet::InputError& error) {
    return Fail(kInput, error.what());
  } catch (const facet::RunEndedError& error) {
    return Fail(error.exit_code(), error.what());
  } catch (const facet::OutputError& error) {
    return Fail(kOutput, error.what());
  } catch (const std::exception& error) {
    return Fail(kInternal, std::string("internal error: ") + error.what());
  } catch (...) {
    return Fail(kInternal, "internal error of unknown kind");
  }
}
