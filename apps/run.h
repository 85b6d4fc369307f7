// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "run_sequence.h"

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

/// What `facet run` is told on the command line.
struct RunArguments {
  std::string sequence, out, config, calibration, imu_calibration;
  std::string pipeline;  // empty: what the configuration says
  std::vector<std::string> overrides;
  std::vector<std::string> topics;  // role=name
  RunRange range;
  int threads = 1;
  int mesh_every = 0;
  std::string mesh_format = "ply";
  bool quiet = false, verbose = false;
  std::string view;  // port of the live viewer, or empty: none
  std::string view_host = "127.0.0.1";
  bool view_exit = false;  // at the end of the run instead of at Ctrl-C
  /// For other programs than `facet`. Hears each note and warning, which otherwise go to stderr.
  std::function<void(const std::string& text)> on_message;
  std::function<void(int done, int total)> on_frame;  ///< called after each frame
  std::string publish;   // port for Foxglove, on the viewer's server, or empty: not published
  std::string map;       // folder with the map of places of earlier runs, or empty
  std::string save_map;  // folder for the map of places with this run, or empty
  std::string record;    // MCAP file of the same messages, or empty
};

/// `facet run`. Throws InputError, ConfigError, OutputError or RunEndedError.
void RunCommand(const RunArguments& arguments);

}  // namespace facet
