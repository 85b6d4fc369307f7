// SPDX-License-Identifier: BSD-2-Clause
// Serves the page, its data as a WebSocket and some downloads to browsers. Knows nothing of what
// the messages mean.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "facet/viewer/socket_session.h"
#include "facet/viewer/view_board.h"

namespace facet {

/// A file that clients may save. No path of a client reaches the file system: these names are all
/// there are.
struct ViewDownload {
  std::string name;  ///< after "/download/"
  std::string type;  ///< for the header Content-Type
  /// Called on the server's thread for each request; may throw std::exception, which the client is
  /// told of.
  std::function<std::string()> make;
};

struct ViewServerOptions {
  std::string host = "127.0.0.1";  ///< address or name to bind; any but this machine needs a token
  int port = 8470;                 ///< 0: one that the system chooses
  int num_ports = 20;              ///< tried from `port` on, where others use them
  std::string token;               ///< that clients must name; empty: none
  int max_connections = 64;        ///< at the same time; more are refused with status 503
  std::size_t max_message_bytes = 1 << 16;  ///< from a client; a longer one ends its connection
  std::size_t max_header_bytes = 1 << 13;
  std::chrono::milliseconds request_timeout{10000};  ///< for a request to arrive
  std::chrono::milliseconds idle_timeout{60000};     ///< without a sign of life of a client
  std::optional<SocketProtocol> protocol;            ///< spoken on any path
  /// Called on the server's thread, at this period and while there are pages, to bring the board
  /// up to date; may be empty.
  std::function<void()> update;
  std::chrono::milliseconds update_period{100};
};

/// Has one thread of its own, from the constructor to the destructor. Methods are thread-safe.
class ViewServer {
 public:
  /// Listens. Throws ConfigError where host or ports cannot be used, or where a host that others
  /// can reach comes without a token.
  ViewServer(const ViewServerOptions& options, std::vector<ViewDownload> downloads);
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  /// What is posted reaches the clients soon.
  ViewBoard& board() { return *board_; }

  /// Replaces the downloads, before postings that are announced after it.
  void SetDownloads(std::vector<ViewDownload> downloads);

  /// Postings since the last call may be sent, and so may what other sessions have; to be called
  /// after a group of them.
  void Announce();

  /// Returns when every client has been handed all that was announced, or after `patience`: before
  /// the server ends.
  void WaitUntilSent(std::chrono::milliseconds patience);

  int port() const;
  std::string url() const;      ///< of the page, with the token
  int num_clients() const;      ///< open WebSockets of pages
  int num_connections() const;  ///< of all kinds

 private:
  class Impl;
  std::shared_ptr<ViewBoard> board_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace facet
