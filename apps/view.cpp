// SPDX-License-Identifier: BSD-2-Clause
// `facet view`: finished results in the browser.
#include "view.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <thread>

#include "interrupts.h"
#include "recorded_images.h"

#include "facet/eval/ground_truth.h"
#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"
#include "facet/viewer/result_view.h"
#include "facet/viewer/view_access.h"
#include "facet/viewer/view_server.h"

namespace facet {

void WaitForInterrupt() {
  constexpr std::chrono::milliseconds kPeriod{50};
  while (!WasInterrupted())
    std::this_thread::sleep_for(kPeriod);
}

int ParsePort(const std::string& option, const std::string& text) {
  const auto port = ParseInteger(text);
  if (port && *port >= 0 && *port <= 65535) return static_cast<int>(*port);
  throw ConfigError(option + "=" + text + ": a port from 0 to 65535 is expected");
}

void PrintAddress(const ViewServer& server, int wanted_port) {
  if (wanted_port != 0 && server.port() != wanted_port)
    std::fprintf(stderr, "facet: note: port %d is in use\n", wanted_port);
  std::printf("open %s in a browser; Ctrl-C ends\n", server.url().c_str());
  std::fflush(stdout);
}

namespace {

/// Those of the recording that is named, or of the folder with the truth if it has some.
std::shared_ptr<const CameraImages> ImagesFor(const ViewArguments& arguments) {
  if (!arguments.recording.empty()) return OpenRecordedImages(arguments.recording);
  if (arguments.truth.empty() || !std::filesystem::is_directory(arguments.truth)) return nullptr;
  try {
    return OpenRecordedImages(arguments.truth);
  } catch (const InputError&) {
    return nullptr;  // a truth without images is a truth
  }
}

}  // namespace

void ViewCommand(const ViewArguments& arguments) {
  std::optional<GroundTruth> truth;
  if (!arguments.truth.empty()) truth = LoadGroundTruth(arguments.truth);
  const ResultView view({arguments.results.begin(), arguments.results.end()},
                        truth ? &*truth : nullptr,
                        "",
                        ImagesFor(arguments));
  ViewServerOptions options;
  options.host = arguments.host;
  options.port = arguments.port;
  if (!IsLoopback(options.host)) options.token = RandomToken();
  CatchInterrupts();
  ViewServer server(options, view.Downloads());
  view.PostTo(server.board());
  PrintAddress(server, arguments.port);
  WaitForInterrupt();
}

}  // namespace facet
