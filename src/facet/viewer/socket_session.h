// SPDX-License-Identifier: BSD-2-Clause
// What is spoken over one WebSocket of the server.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "facet/viewer/view_board.h"

namespace facet {

/// One client. Called on the server's thread only.
class SocketSession {
 public:
  struct Frame {
    SharedBytes bytes;
    bool is_text = false;
  };

  virtual ~SocketSession() = default;

  /// What is to be sent next; empty: nothing for now.
  virtual std::optional<Frame> Next() = 0;

  /// What the client has sent; Next is called afterwards. False ends the connection.
  virtual bool Receive(std::string_view bytes, bool is_text) = 0;
};

/// A protocol beside that of the page, which clients choose by the header Sec-WebSocket-Protocol.
struct SocketProtocol {
  std::vector<std::string> names;    ///< any of them
  std::vector<std::string> origins;  ///< of pages that may speak it, besides the server's own
  std::function<std::unique_ptr<SocketSession>()> make_session;
};

}  // namespace facet
