// SPDX-License-Identifier: BSD-2-Clause
#include "run_publishing.h"

#include <utility>
#include <vector>

namespace facet {

RunPublishing::RunPublishing(const RunArguments& arguments, const std::string& name) {
  if (!arguments.publish.empty()) foxglove_.emplace("facet " + name);
  if (!arguments.record.empty()) recorder_.emplace(arguments.record);
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

std::string RunPublishing::Finish() {
  if (!publisher_) return {};
  publisher_->Finish();
  if (recorder_) recorder_->Commit();
  if (publisher_->num_dropped() == 0) return {};
  return std::to_string(publisher_->num_dropped()) +
         " frames were not published: the machine was too slow for their messages";
}

}  // namespace facet
