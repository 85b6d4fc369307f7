// SPDX-License-Identifier: BSD-2-Clause
// Published messages over the Foxglove WebSocket protocol
// (https://github.com/foxglove/ws-protocol), on the viewer's server.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>

#include "facet/publish/publisher.h"
#include "facet/viewer/socket_session.h"

namespace facet {

/// Keeps the newest message of each topic and slot; clients that come late, or subscribe late, get
/// them, and slow ones never those in between, so no queue grows. Thread-safe.
class FoxgloveServer {
 public:
  /// `name`: what clients show as the server's.
  explicit FoxgloveServer(std::string name);

  /// For ViewServerOptions::protocol. Its sessions keep what they need of this object.
  SocketProtocol Protocol() const;

  /// The message may be sent from now on; the server is to be told (ViewServer::Announce).
  void Add(const PublishedMessage& message);

 private:
  struct Shared {
    std::string name, session_id;
    std::array<ViewBoard, kChannels.size()>
        boards;  ///< by topic; each message with its stamp before
  };
  class Session;

  std::shared_ptr<Shared> shared_;
};

}  // namespace facet
