// SPDX-License-Identifier: BSD-2-Clause
#include "run_publishing.h"

#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "facet/io/errors.h"

namespace facet {

RunPublishing::RunPublishing(const RunArguments& arguments, const std::string& name) {
  if (!arguments.publish.empty()) foxglove_.emplace("facet " + name);
  if (arguments.record.empty()) return;
  std::error_code error;
  if (std::filesystem::is_directory(arguments.record, error))
    throw ConfigError("--record " + arguments.record + ": is a folder; name a file, as run.mcap");
  recorder_.emplace(arguments.record);
}

std::optional<SocketProtocol> RunPublishing::Protocol() const {
  if (!foxglove_) return std::nullopt;
  return foxglove_->Protocol();
}

void RunPublishing::Begin(const StereoRig& rig, const SurfaceMapOptions& map, LiveView* live) {
  std::vector<MessageSink> sinks;
  if (recorder_)
    sinks.emplace_back([this](const PublishedMessage& message) { recorder_->Add(message); });
  if (foxglove_ && live != nullptr) {
    sinks.emplace_back([this, live](const PublishedMessage& message) {
      foxglove_->Add(message);
      live->Announce();
    });
  }
  if (!sinks.empty()) publisher_ = std::make_unique<Publisher>(rig, map, std::move(sinks));
}

void RunPublishing::Finish() {
  if (!publisher_) return;
  publisher_->Finish();
  if (recorder_) recorder_->Commit();
  if (publisher_->num_dropped() == 0) return;
  std::fprintf(stderr,
               "facet: warning: %lld frames were not published: the machine is too slow for their "
               "messages\n",
               static_cast<long long>(publisher_->num_dropped()));
}

}  // namespace facet
