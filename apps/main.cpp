// SPDX-License-Identifier: BSD-2-Clause
// The facet program: one small file per command, one exit code per kind of failure.
#include <algorithm>
#include <exception>
#include <iostream>
#include <string>

#include "compare.h"
#include "config.h"
#include "evaluate.h"
#include "run.h"
#include "simulate.h"
#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>

#include "facet/io/errors.h"

namespace {

enum ExitCode { kDone = 0, kInternal = 1, kUsage = 2, kInput = 3 };

int Fail(int code, std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::cerr << "facet: error: " << message << std::endl;
  return code;
}

/// CLI11 would say that a command is missing where there is one that it does not know.
bool IsUnknownCommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return false;
  const std::string name = argv[1];
  return app.get_subcommands([&](const CLI::App* c) { return c->check_name(name); }).empty();
}

int RunProgram(int argc, char** argv) {
  CLI::App app("Facet: stereo visual-inertial odometry", "facet");
  app.set_version_flag("--version", "facet " FACET_VERSION);
  app.require_subcommand(1);
  facet::AddRunCommand(app);
  facet::AddEvaluateCommand(app);
  facet::AddCompareCommand(app);
  facet::AddConfigCommand(app);
  facet::AddSimulateCommand(app, argc, argv);
  try {
    if (IsUnknownCommand(app, argc, argv)) {
      return Fail(kUsage, "unknown command '" + std::string(argv[1]) + "'; see facet --help");
    }
    app.parse(argc, argv);
    return kDone;
  } catch (const CLI::ParseError& error) {
    const auto code = static_cast<CLI::ExitCodes>(error.get_exit_code());
    if (code == CLI::ExitCodes::Success) return app.exit(error);  // --help, --version
    return Fail(kUsage, std::string(error.what()) + "; see facet --help");
  }
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  try {
    return RunProgram(argc, argv);
  } catch (const facet::ConfigError& error) {
    return Fail(kUsage, error.what());
  } catch (const facet::InputError& error) {
    return Fail(kInput, error.what());
  } catch (const facet::RunEndedError& error) {
    return Fail(error.exit_code(), error.what());
  } catch (const facet::OutputError& error) {
    return Fail(kInternal, error.what());
  } catch (const std::exception& error) {
    return Fail(kInternal, std::string("internal error: ") + error.what());
  } catch (...) {
    return Fail(kInternal, "internal error of unknown kind");
  }
}
