// SPDX-License-Identifier: BSD-2-Clause
// `facet run --publish` and `--record`: the run as messages, for listeners and into a file.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "run.h"

#include "facet/publish/foxglove_server.h"
#include "facet/publish/mcap_recorder.h"
#include "facet/publish/publisher.h"
#include "facet/viewer/live_view.h"

namespace facet {

/// Not thread-safe.
class RunPublishing {
 public:
  /// Creates the file of `--record`. Throws ConfigError and OutputError.
  RunPublishing(const RunArguments& arguments, const std::string& name);

  /// What the viewer's server is to speak besides; empty without `--publish`.
  std::optional<SocketProtocol> Protocol() const;

  /// From now on messages are made, if they are wanted. `live` is told of them; null without
  /// `--publish`. It must live longer than this object.
  void Begin(const StereoRig& rig, const SurfaceMapOptions& map, LiveView* live);

  /// Null if nothing is wanted.
  Publisher* publisher() { return publisher_.get(); }

  /// After the run, when its result is safe: everything is published, and the file complete. Throws
  /// OutputError; says on stderr if something was left out.
  void Finish();

 private:
  std::optional<FoxgloveServer> foxglove_;
  std::optional<McapRecorder> recorder_;
  std::unique_ptr<Publisher> publisher_;  // last: its thread uses the others
};

}  // namespace facet
