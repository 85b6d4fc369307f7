// SPDX-License-Identifier: BSD-2-Clause
// The server against clients that are wrong, slow, many or hostile.
#include "facet/viewer/view_server.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <deque>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include "facet/io/errors.h"

namespace facet {
namespace {

namespace asio = boost::asio;
namespace websocket = boost::beast::websocket;
using Tcp = asio::ip::tcp;
using Error = boost::system::error_code;

ViewServerOptions AnyPort() {
  ViewServerOptions options;
  options.port = 0;
  options.request_timeout = std::chrono::milliseconds(2000);
  return options;
}

std::vector<ViewDownload> OneDownload() {
  return {{"map.ply", "application/octet-stream", [] { return std::string("ply of the map"); }},
          {"broken.ply", "application/octet-stream", []() -> std::string {
             throw std::runtime_error("disk gone");
           }}};
}

/// A socket that gives up after some seconds.
class Client {
 public:
  explicit Client(const ViewServer& server, int receive_bytes = 0) : socket_(context_) {
    const Tcp::endpoint endpoint(asio::ip::make_address("127.0.0.1"),
                                 static_cast<std::uint16_t>(server.port()));
    socket_.open(Tcp::v4());
    if (receive_bytes > 0) socket_.set_option(Tcp::socket::receive_buffer_size(receive_bytes));
    socket_.connect(endpoint);
    const timeval patience{5, 0};
    setsockopt(socket_.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    setsockopt(socket_.native_handle(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
  }

  void Send(const std::string& bytes) {
    Error ignored;  // the server may have hung up
    asio::write(socket_, asio::buffer(bytes), ignored);
  }

  /// All that comes until the server ends the connection. (Asio itself would wait for ever.)
  std::string ReadAll() {
    std::string text;
    std::array<char, 4096> part{};
    ssize_t num = 0;
    while ((num = recv(socket_.native_handle(), part.data(), part.size(), 0)) > 0)
      text.append(part.data(), static_cast<std::size_t>(num));
    return num < 0 && errno == EAGAIN ? "no end: " + text : text;
  }

  Tcp::socket& socket() { return socket_; }

 private:
  asio::io_context context_;
  Tcp::socket socket_;
};

std::string Get(const std::string& target, const std::string& more = "") {
  return "GET " + target + " HTTP/1.1\r\nHost: 127.0.0.1:1\r\nConnection: close\r\n" + more +
         "\r\n";
}

std::string Ask(const ViewServer& server, const std::string& request) {
  Client client(server);
  client.Send(request);
  return client.ReadAll();
}

int StatusOf(const std::string& answer) {
  return answer.starts_with("HTTP/1.1 ") ? std::stoi(answer.substr(9)) : 0;
}

std::string Upgrade(const std::string& more = "") {
  return "GET /live HTTP/1.1\r\nHost: 127.0.0.1:1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
         "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
         more + "\r\n";
}

using Socket = websocket::stream<Tcp::socket&>;

std::string ReadMessage(Socket& socket) {
  boost::beast::flat_buffer buffer;
  socket.read(buffer);
  return boost::beast::buffers_to_string(buffer.data());
}

template <class Condition>
bool Eventually(const Condition& condition) {
  for (int i = 0; i < 2000 && !condition(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return condition();
}

/// After whatever a test did, the page and the data still come.
void ExpectAlive(ViewServer& server) {
  EXPECT_TRUE(Eventually([&] { return StatusOf(Ask(server, Get("/"))) == 200; }));
  Client client(server);
  Socket socket(client.socket());
  socket.handshake("127.0.0.1:1", "/live");
  server.board().Post("test", "still here");
  server.Announce();
  while (ReadMessage(socket) != "still here") {
  }
}

TEST(ViewServer, ServesThePageAndItsDownloadsAndNothingElse) {
  ViewServer server(AnyPort(), OneDownload());
  const std::string page = Ask(server, Get("/"));
  EXPECT_EQ(StatusOf(page), 200);
  EXPECT_NE(page.find("<!doctype html>"), std::string::npos);
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'none'"), std::string::npos);
  const std::string map = Ask(server, Get("/download/map.ply"));
  EXPECT_TRUE(map.ends_with("\r\n\r\nply of the map"));
  EXPECT_NE(map.find("attachment; filename=\"map.ply\""), std::string::npos);
  EXPECT_EQ(StatusOf(Ask(server, Get("/download/broken.ply"))), 500);
  for (const char* target : {"/download/",
                             "/download/map.pl",
                             "/download/../../../../etc/passwd",
                             "/../etc/passwd",
                             "/download/%2e%2e/%2e%2e/etc/passwd",
                             "//etc/passwd",
                             "/download//etc/passwd",
                             "/live",
                             "/index.html/..",
                             "*",
                             "/download/map.ply%00",
                             "http://127.0.0.1/etc/passwd"}) {
    EXPECT_EQ(StatusOf(Ask(server, Get(target))), 404) << target;
  }
}

TEST(ViewServer, ThePageIsCompressedForWhoUnderstandsThat) {
  ViewServer server(AnyPort(), {});
  const std::string answer = Ask(server, Get("/", "Accept-Encoding: gzip, br\r\n"));
  EXPECT_NE(answer.find("Content-Encoding: gzip"), std::string::npos);
  EXPECT_EQ(answer.substr(answer.find("\r\n\r\n") + 4, 2), "\x1f\x8b");
}

TEST(ViewServer, OtherHostsAndOriginsAreRefused) {
  ViewServer server(AnyPort(), OneDownload());
  const std::string rebound = "GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n";
  EXPECT_EQ(StatusOf(Ask(server, rebound)), 403);
  EXPECT_EQ(StatusOf(Ask(server, "GET / HTTP/1.1\r\nConnection: close\r\n\r\n")), 403);
  EXPECT_EQ(StatusOf(Ask(server, Get("/download/map.ply", "Origin: http://evil.example\r\n"))),
            403);
  Client client(server);
  client.Send(Upgrade("Origin: http://evil.example\r\n"));
  EXPECT_EQ(StatusOf(client.ReadAll()), 403);
  ExpectAlive(server);
}

TEST(ViewServer, AHostThatOthersReachNeedsAToken) {
  ViewServerOptions options = AnyPort();
  options.host = "0.0.0.0";
  EXPECT_THROW(ViewServer(options, {}), ConfigError);
  options.token = "secret";
  ViewServer server(options, OneDownload());
  EXPECT_NE(server.url().find("?token=secret"), std::string::npos);
  EXPECT_EQ(StatusOf(Ask(server, Get("/"))), 403);
  EXPECT_EQ(StatusOf(Ask(server, Get("/download/map.ply"))), 403);
  EXPECT_EQ(StatusOf(Ask(server, Get("/?token=secret"))), 200);
  EXPECT_EQ(StatusOf(Ask(server, Get("/download/map.ply?token=secret"))), 200);
  Client client(server);
  client.Send(Upgrade());
  EXPECT_EQ(StatusOf(client.ReadAll()), 403);
}

TEST(ViewServer, APortInUseIsPassedOver) {
  ViewServer first(AnyPort(), {});
  ViewServerOptions options = AnyPort();
  options.port = first.port();
  ViewServer second(options, {});
  EXPECT_GT(second.port(), first.port());
  options.num_ports = 1;
  EXPECT_THROW(ViewServer(options, {}), ConfigError);
}

TEST(ViewServer, MalformedHttpIsAnsweredOrDropped) {
  ViewServer server(AnyPort(), {});
  const std::vector<std::string> requests = {
      "\r\n\r\n",
      "GET\r\n\r\n",
      "GET / HTTP/9.9\r\n\r\n",
      std::string("\0\1\2\3\xff\xfe\r\n\r\n", 10),
      "GET / HTTP/1.1\r\nHost 127.0.0.1\r\n\r\n",
      "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + std::string(1 << 16, 'x') + "\r\n\r\n",
      "GET /" + std::string(1 << 16, 'a') + " HTTP/1.1\r\n\r\n",
      "POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 5\r\n\r\nhello",
      "POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 99999999999\r\n\r\n",
      "POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nTransfer-Encoding: chunked\r\n\r\nfffffffff\r\n",
      "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: -1\r\n\r\n",
      "DELETE / HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n",
      std::string(1 << 20, 'G')};
  for (const std::string& request : requests) {
    const int status = StatusOf(Ask(server, request));
    EXPECT_TRUE(status == 0 || (status >= 400 && status < 500))
        << status << " for " << request.substr(0, 50);
  }
  ExpectAlive(server);
}

TEST(ViewServer, ARequestThatDoesNotEndTimesOut) {
  ViewServerOptions options = AnyPort();
  options.request_timeout = std::chrono::milliseconds(100);
  ViewServer server(options, {});
  Client client(server);
  client.Send("GET / HTTP/1.1\r\nHost:");
  EXPECT_EQ(client.ReadAll(), "");
}

TEST(ViewServer, MalformedFramesEndTheirConnectionOnly) {
  ViewServer server(AnyPort(), {});
  const std::vector<std::string> frames = {
      std::string("\x81\x05hello", 7),                     // not masked
      std::string("\xf1\x80\x00\x00\x00\x00", 6),          // reserved bits
      std::string("\x83\x80\x00\x00\x00\x00", 6),          // reserved opcode
      std::string("\x80\x80\x00\x00\x00\x00", 6),          // continues nothing
      std::string("\x09\x80\x00\x00\x00\x00", 6),          // ping in fragments
      std::string("\x89\xfe\x00\x7e\x00\x00\x00\x00", 8),  // ping that is too long
      std::string("\x81\xff\xff\xff\xff\xff\xff\xff\xff\xff\x00\x00\x00\x00", 14),  // length
      std::string("\x88\x81\x00\x00\x00\x00\x01", 7),   // close code cut off
      std::string("\x81\x81\x00\x00\x00\x00\xff", 7)};  // text that is not UTF-8
  for (const std::string& frame : frames) {
    Client client(server);
    Socket(client.socket()).handshake("127.0.0.1:1", "/live");
    client.Send(frame);
    EXPECT_FALSE(client.ReadAll().starts_with("no end")) << "opcode " << int{frame[0]};
  }
  Client hasty(server);
  hasty.Send(Upgrade() + frames[0]);
  EXPECT_EQ(StatusOf(hasty.ReadAll()), 400);
  ExpectAlive(server);
}

TEST(ViewServer, AMessageOf64MegabytesIsRefused) {
  ViewServer server(AnyPort(), {});
  Client client(server);
  Socket socket(client.socket());
  socket.handshake("127.0.0.1:1", "/live");
  Error error;
  socket.write(asio::buffer(std::string(64 << 20, 'x')), error);
  boost::beast::flat_buffer buffer;
  socket.read(buffer, error);
  EXPECT_TRUE(error);
  EXPECT_TRUE(Eventually([&] { return server.num_clients() == 0; }));
  ExpectAlive(server);
}

TEST(ViewServer, Of200ConnectionsSomeAreServedAndTheOthersRefused) {
  ViewServer server(AnyPort(), {});
  std::deque<Client> clients;
  for (int i = 0; i < 200; ++i)
    clients.emplace_back(server);
  EXPECT_TRUE(Eventually([&] { return server.num_connections() == 64; }));
  EXPECT_EQ(StatusOf(clients[64].ReadAll()), 503);
  EXPECT_FALSE(clients.back().ReadAll().starts_with("no end"));  // not even told
  clients.front().Send(Get("/"));
  EXPECT_EQ(StatusOf(clients.front().ReadAll()), 200);
  clients.clear();
  EXPECT_TRUE(Eventually([&] { return server.num_connections() == 0; }));
  ExpectAlive(server);
}

TEST(ViewServer, SeveralClientsGetTheBoardAndItsNews) {
  ViewServer server(AnyPort(), {});
  server.board().Post("a", "one");
  Client first(server), second(server);
  Socket a(first.socket()), b(second.socket());
  a.handshake("127.0.0.1:1", "/live");
  b.handshake("127.0.0.1:1", "/live");
  EXPECT_EQ(ReadMessage(a), "one");
  EXPECT_EQ(ReadMessage(b), "one");
  server.board().Post("b", "two");
  server.Announce();
  EXPECT_EQ(ReadMessage(a), "two");
  EXPECT_EQ(ReadMessage(b), "two");
}

TEST(ViewServer, ASlowReaderHoldsUpNobodyAndGetsTheNewestInTheEnd) {
  ViewServer server(AnyPort(), {});
  Client slow_client(server, 4096), quick_client(server);
  Socket slow(slow_client.socket()), quick(quick_client.socket());
  slow.handshake("127.0.0.1:1", "/live");
  quick.handshake("127.0.0.1:1", "/live");
  constexpr int kNumMessages = 50;
  const std::string mesh(1 << 20, 'm');
  for (int i = 1; i <= kNumMessages; ++i) {
    const std::string message = mesh + std::to_string(i);
    server.board().Post("mesh", message);
    server.Announce();
    EXPECT_EQ(ReadMessage(quick), message);
  }
  EXPECT_LT(server.board().num_bytes(), 2 * mesh.size());
  int num_read = 1;
  while (ReadMessage(slow) != mesh + std::to_string(kNumMessages))
    ++num_read;
  EXPECT_LT(num_read, kNumMessages);
}

TEST(ViewServer, AClientWithoutASignOfLifeIsDropped) {
  ViewServerOptions options = AnyPort();
  options.idle_timeout = std::chrono::milliseconds(200);
  ViewServer server(options, {});
  Client client(server, 4096);
  Socket socket(client.socket());
  socket.handshake("127.0.0.1:1", "/live");
  server.board().Post("mesh", std::string(32 << 20, 'm'));
  server.Announce();
  EXPECT_TRUE(Eventually([&] { return server.num_clients() == 1; }));
  EXPECT_TRUE(Eventually([&] { return server.num_clients() == 0; }));
}

TEST(ViewServer, UpdatesOnlyWhileSomebodyLooks) {
  std::atomic<int> num_updates{0};
  ViewServerOptions options = AnyPort();
  options.update_period = std::chrono::milliseconds(5);
  options.update = [&] { ++num_updates; };
  ViewServer server(options, {});
  Ask(server, Get("/"));
  EXPECT_EQ(num_updates, 0);
  {
    Client client(server);
    Socket socket(client.socket());
    socket.handshake("127.0.0.1:1", "/live");
    EXPECT_TRUE(Eventually([&] { return num_updates > 3; }));
  }
  EXPECT_TRUE(Eventually([&] { return server.num_clients() == 0; }));
}

}  // namespace
}  // namespace facet
