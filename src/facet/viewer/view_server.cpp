// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/view_server.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <future>
#include <set>
#include <thread>
#include <utility>

#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "facet/io/errors.h"
#include "facet/viewer/http_answer.h"
#include "facet/viewer/view_access.h"

namespace facet {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;
using Error = boost::system::error_code;
using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

std::string_view View(beast::string_view text) {
  return {text.data(), text.size()};
}

class SocketClient;

/// The page's data: the board's messages one after the other. What the page sends is thrown away.
class PageSession : public SocketSession {
 public:
  explicit PageSession(const ViewBoard& board) : board_(board) {}

  std::optional<Frame> Next() override {
    const auto next = board_.NextAfter(number_);
    if (!next) return std::nullopt;
    number_ = next->number;
    return Frame{next->message, false};
  }

  bool Receive(std::string_view /*bytes*/, bool /*is_text*/) override { return true; }

 private:
  const ViewBoard& board_;
  std::uint64_t number_ = 0;  // of the newest message that was sent
};

/// What connections and listener share. Used on the server's thread only, but for the counts.
struct Service {
  Service(const ViewServerOptions& chosen,
          std::vector<ViewDownload> downloads,
          std::shared_ptr<ViewBoard> view_board)
      : options(chosen),
        access(chosen.host, chosen.token),
        answers(access, std::move(downloads)),
        board(std::move(view_board)),
        update_timer(context) {}

  void Announce();
  bool IsSending() const;
  void AddClient(SocketClient* client);
  void RemoveClient(SocketClient* client);
  void RunUpdate();
  void ScheduleUpdate();
  /// Whatever goes wrong here is the viewer's business: the run that it shows goes on.
  void Warn(const std::exception& error);

  const ViewServerOptions options;
  const ViewAccess access;
  HttpAnswers answers;
  const std::shared_ptr<ViewBoard> board;
  std::set<SocketClient*> clients;
  std::atomic<int> num_pages{0}, num_sockets{0}, num_connections{0};
  int num_refused = 0;  // whose refusal is under way
  bool is_update_scheduled = false, has_warned = false;
  // Last but for the timer, which uses it: what it destroys refers to the members above.
  asio::io_context context{1};
  asio::steady_timer update_timer;
};

/// Counts a connection for as long as it is there.
class Counted {
 public:
  explicit Counted(Service& service) : service_(&service) { ++service.num_connections; }
  Counted(Counted&& other) noexcept : service_(std::exchange(other.service_, nullptr)) {}
  Counted& operator=(Counted&&) = delete;
  ~Counted() {
    if (service_ != nullptr) --service_->num_connections;
  }

 private:
  Service* service_;
};

/// A WebSocket: sends what its session has, one frame after the other.
class SocketClient : public std::enable_shared_from_this<SocketClient> {
 public:
  /// `subprotocol`: the one that was chosen; empty for the page.
  SocketClient(Service& service,
               beast::tcp_stream stream,
               Counted counted,
               std::unique_ptr<SocketSession> session,
               std::string subprotocol)
      : service_(service),
        counted_(std::move(counted)),
        socket_(std::move(stream)),
        session_(std::move(session)),
        subprotocol_(std::move(subprotocol)) {}

  ~SocketClient() { service_.RemoveClient(this); }

  bool is_page() const { return subprotocol_.empty(); }
  bool is_sending() const { return message_ != nullptr; }

  void Start(const Request& request) {
    beast::get_lowest_layer(socket_).expires_never();
    websocket::stream_base::timeout timeout{};
    timeout.handshake_timeout = service_.options.request_timeout;
    timeout.idle_timeout = service_.options.idle_timeout;
    timeout.keep_alive_pings = true;  // a client that no longer reads does not answer them
    socket_.set_option(timeout);
    if (!is_page()) {
      socket_.set_option(websocket::stream_base::decorator(
          [name = subprotocol_](websocket::response_type& response) {
            response.set(http::field::sec_websocket_protocol, name);
          }));
    }
    socket_.read_message_max(service_.options.max_message_bytes);
    const auto self = shared_from_this();
    socket_.async_accept(request, [this, self](Error error) {
      if (error) return;
      service_.AddClient(this);
      Read();
      Send();
    });
  }

  /// The next frame, unless one is under way.
  void Send() {
    if (message_) return;
    const auto next = session_->Next();
    if (!next) return;
    message_ = next->bytes;
    socket_.text(next->is_text);
    const auto self = shared_from_this();
    socket_.async_write(asio::buffer(*message_), [this, self](Error error, std::size_t) {
      message_ = nullptr;
      if (!error) Send();
    });
  }

 private:
  void Read() {
    const auto self = shared_from_this();
    socket_.async_read(buffer_, [this, self](Error error, std::size_t) {
      const std::string received = error ? "" : beast::buffers_to_string(buffer_.data());
      buffer_.consume(buffer_.size());
      // With its reading a connection ends: the last one who holds the client lets go.
      if (error || !session_->Receive(received, socket_.got_text()))
        return beast::get_lowest_layer(socket_).close();
      Send();
      Read();
    });
  }

  Service& service_;
  Counted counted_;
  websocket::stream<beast::tcp_stream> socket_;
  const std::unique_ptr<SocketSession> session_;
  const std::string subprotocol_;
  beast::flat_buffer buffer_;
  SharedBytes message_;  // under way
};

void Service::Announce() {
  for (SocketClient* client : clients)
    client->Send();
}

bool Service::IsSending() const {
  return std::ranges::any_of(clients, [](const SocketClient* c) { return c->is_sending(); });
}

void Service::AddClient(SocketClient* client) {
  clients.insert(client);
  num_sockets = static_cast<int>(clients.size());
  if (!client->is_page()) return;
  ++num_pages;
  RunUpdate();
  ScheduleUpdate();
}

void Service::RemoveClient(SocketClient* client) {
  if (clients.erase(client) > 0 && client->is_page()) --num_pages;
  num_sockets = static_cast<int>(clients.size());
}

void Service::RunUpdate() {
  if (!options.update) return;
  try {
    options.update();
  } catch (const std::exception& error) {
    Warn(error);
  }
  Announce();
}

void Service::Warn(const std::exception& error) {
  if (std::exchange(has_warned, true)) return;
  std::fprintf(stderr, "facet: warning: the viewer had an error: %s\n", error.what());
}

void Service::ScheduleUpdate() {
  if (!options.update || is_update_scheduled) return;
  is_update_scheduled = true;
  update_timer.expires_after(options.update_period);
  update_timer.async_wait([this](Error error) {
    is_update_scheduled = false;
    if (error || num_pages == 0) return;
    RunUpdate();
    ScheduleUpdate();
  });
}

/// The first of the client's subprotocols that the server speaks; empty: none.
std::string ChooseSubprotocol(const Request& request, const std::optional<SocketProtocol>& spoken) {
  if (!spoken) return {};
  std::string_view offered = View(request[http::field::sec_websocket_protocol]);
  while (!offered.empty()) {
    const std::size_t comma = std::min(offered.find(','), offered.size());
    std::string_view name = offered.substr(0, comma);
    offered.remove_prefix(std::min(comma + 1, offered.size()));
    while (name.starts_with(' '))
      name.remove_prefix(1);
    while (name.ends_with(' '))
      name.remove_suffix(1);
    if (std::ranges::find(spoken->names, name) != spoken->names.end()) return std::string(name);
  }
  return {};
}

/// Answers requests until the client has enough, or becomes a SocketClient.
class HttpClient : public std::enable_shared_from_this<HttpClient> {
 public:
  HttpClient(Service& service, Tcp::socket socket)
      : service_(service), counted_(service), stream_(std::move(socket)) {}

  void Read() {
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(service_.options.max_header_bytes));
    parser_->body_limit(std::uint64_t{0});
    stream_.expires_after(service_.options.request_timeout);
    const auto self = shared_from_this();
    http::async_read(stream_, buffer_, *parser_, [this, self](Error error, std::size_t) {
      if (error == http::error::end_of_stream) return Close();
      if (error && error.category() == http::make_error_code(http::error::end_of_stream).category())
        return Write({400, "text/plain", "This is not a request.\n", false, {}}, false);
      if (!error) Handle();
    });
  }

 private:
  void Handle() {
    const Request& request = parser_->get();
    HttpQuestion question;
    question.request.host = View(request[http::field::host]);
    question.request.target = View(request.target());
    if (request.find(http::field::origin) != request.end())
      question.request.origin = View(request[http::field::origin]);
    question.takes_gzip =
        request[http::field::accept_encoding].find("gzip") != beast::string_view::npos;
    question.is_get = request.method() == http::verb::get || request.method() == http::verb::head;
    if (websocket::is_upgrade(request)) {
      const std::string subprotocol = ChooseSubprotocol(request, service_.options.protocol);
      std::unique_ptr<SocketSession> session = MakeSession(question.request, subprotocol);
      if (session && buffer_.size() > 0)
        return Write({400, "text/plain", "Frames come after the handshake.\n", false, {}}, false);
      if (session) {
        const auto client = std::make_shared<SocketClient>(
            service_, std::move(stream_), std::move(counted_), std::move(session), subprotocol);
        return client->Start(request);
      }
    }
    is_head_ = request.method() == http::verb::head;
    Write(service_.answers.Answer(question), request.keep_alive());
  }

  /// Null where the client may not have one, or asks for what there is not.
  std::unique_ptr<SocketSession> MakeSession(ViewRequest request,
                                             const std::string& subprotocol) const {
    const std::optional<SocketProtocol>& protocol = service_.options.protocol;
    if (!subprotocol.empty()) {
      const auto& origins = protocol->origins;
      if (request.origin && std::ranges::find(origins, *request.origin) != origins.end())
        request.origin.reset();
    } else if (ParseTarget(request.target).path != "/live") {
      return nullptr;
    }
    if (service_.access.Refusal(request) != nullptr) return nullptr;
    if (!subprotocol.empty()) return protocol->make_session();
    return std::make_unique<PageSession>(*service_.board);
  }

  void Write(HttpAnswer answer, bool keep_alive) {
    response_ = Response();
    response_.result(static_cast<unsigned>(answer.status));
    response_.version(11);
    response_.keep_alive(keep_alive && answer.status < 400);
    response_.set(http::field::content_type, answer.type);
    response_.set(http::field::cache_control, "no-store");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Referrer-Policy", "no-referrer");
    response_.set("Cross-Origin-Resource-Policy", "same-origin");
    response_.set("Content-Security-Policy",
                  "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
                  "img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; "
                  "form-action 'none'; frame-ancestors 'none'");
    if (answer.is_gzip) response_.set(http::field::content_encoding, "gzip");
    if (!answer.file_name.empty()) {
      response_.set(http::field::content_disposition,
                    "attachment; filename=\"" + answer.file_name + "\"");
    }
    response_.content_length(answer.body.size());
    // The slowest line that large files are still sent over.
    constexpr std::size_t kBytesPerMs = 20;
    stream_.expires_after(service_.options.request_timeout +
                          std::chrono::milliseconds(answer.body.size() / kBytesPerMs));
    if (!is_head_) response_.body() = std::move(answer.body);
    const auto self = shared_from_this();
    http::async_write(stream_, response_, [this, self](Error error, std::size_t) {
      if (error) return;
      if (response_.need_eof() || !response_.keep_alive()) return Close();
      Read();
    });
  }

  // Reads on for a moment: a connection with unread bytes would be reset, and the answer lost.
  void Close() {
    Error ignored;
    stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
    Drain(64);
  }

  void Drain(int num_reads) {
    if (num_reads == 0) return;
    constexpr std::chrono::milliseconds kPatience{500};
    stream_.expires_after(kPatience);
    const auto self = shared_from_this();
    const auto space = asio::buffer(drained_.data(), drained_.size());
    stream_.async_read_some(space, [this, self, num_reads](Error error, std::size_t) {
      if (!error) Drain(num_reads - 1);
    });
  }

  Service& service_;
  Counted counted_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{1 << 16};
  std::optional<http::request_parser<http::empty_body>> parser_;
  Response response_;
  bool is_head_ = false;
  std::array<char, 4096> drained_{};
};

/// Tells a client that there are too many.
class RefusedClient : public std::enable_shared_from_this<RefusedClient> {
 public:
  RefusedClient(Service& service, Tcp::socket socket)
      : service_(service), stream_(std::move(socket)) {
    ++service_.num_refused;
  }
  ~RefusedClient() { --service_.num_refused; }

  void Start() {
    constexpr std::chrono::milliseconds kPatience{500};
    stream_.expires_after(kPatience);
    const auto self = shared_from_this();
    asio::async_write(stream_, asio::buffer(kText.data(), kText.size()), [this, self](Error, auto) {
      Error ignored;
      stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
      stream_.async_read_some(asio::buffer(drained_.data(), drained_.size()),
                              [self](Error, std::size_t) {});
    });
  }

 private:
  static constexpr std::string_view kText =
      "HTTP/1.1 503 Service Unavailable\r\nContent-Type: text/plain\r\nRetry-After: 2\r\n"
      "Connection: close\r\nContent-Length: 38\r\n\r\nToo many connections; try again later.";
  Service& service_;
  beast::tcp_stream stream_;
  std::array<char, 4096> drained_{};
};

Tcp::endpoint Resolve(asio::io_context& context, const std::string& host) {
  Error error;
  Tcp::resolver resolver(context);
  const auto found = resolver.resolve(host, "", Tcp::resolver::passive, error);
  if (error || found.empty())
    throw ConfigError("--host " + host + ": is not an address of this machine");
  return found.begin()->endpoint();
}

}  // namespace

class ViewServer::Impl {
 public:
  Impl(const ViewServerOptions& options,
       std::vector<ViewDownload> downloads,
       std::shared_ptr<ViewBoard> board)
      : service_(options, std::move(downloads), std::move(board)),
        acceptor_(service_.context),
        retry_(service_.context) {
    if (!IsLoopback(options.host) && options.token.empty())
      throw ConfigError("--host " + options.host + ": others can reach it, so it needs a token");
    Listen();
    Accept();
    thread_ = std::thread([this] { Run(); });
  }

  ~Impl() {
    service_.context.stop();
    thread_.join();
  }

  Service& service() { return service_; }
  int port() const { return port_; }

 private:
  void Listen() {
    const ViewServerOptions& options = service_.options;
    Tcp::endpoint endpoint = Resolve(service_.context, options.host);
    const int last = std::min(options.port == 0 ? 0 : options.port + options.num_ports - 1, 65535);
    Error error;
    for (int port = options.port; port <= last; ++port) {
      endpoint.port(static_cast<std::uint16_t>(port));
      Error ignored;
      acceptor_.close(ignored);
      acceptor_.open(endpoint.protocol(), error);
      if (!error) acceptor_.set_option(Tcp::acceptor::reuse_address(true), error);
      if (!error) acceptor_.bind(endpoint, error);
      if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
      if (!error) break;
      if (error != asio::error::address_in_use && error != asio::error::access_denied) break;
    }
    if (error) {
      throw ConfigError("the viewer cannot listen on " + options.host + ", ports " +
                        std::to_string(options.port) + " to " + std::to_string(last) + ": " +
                        error.message() + "; choose another with --host, --port or --view=PORT");
    }
    port_ = acceptor_.local_endpoint().port();
  }

  void Run() {
    while (!service_.context.stopped()) {
      try {
        service_.context.run();
      } catch (const std::exception& error) {
        service_.Warn(error);
      }
    }
  }

  void Accept() {
    acceptor_.async_accept([this](Error error, Tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) return AcceptLater();  // no file descriptors left
      Serve(std::move(socket));
      Accept();
    });
  }

  void AcceptLater() {
    constexpr std::chrono::milliseconds kPause{100};
    retry_.expires_after(kPause);
    retry_.async_wait([this](Error error) {
      if (!error) Accept();
    });
  }

  void Serve(Tcp::socket socket) {
    Error ignored;
    socket.set_option(Tcp::no_delay(true), ignored);
    const int max = service_.options.max_connections;
    if (service_.num_connections < max) {
      std::make_shared<HttpClient>(service_, std::move(socket))->Read();
    } else if (service_.num_refused < max) {
      std::make_shared<RefusedClient>(service_, std::move(socket))->Start();
    }
  }

  Service service_;
  Tcp::acceptor acceptor_;
  asio::steady_timer retry_;
  int port_ = 0;
  std::thread thread_;
};

ViewServer::ViewServer(const ViewServerOptions& options, std::vector<ViewDownload> downloads)
    : board_(std::make_shared<ViewBoard>()),
      impl_(std::make_unique<Impl>(options, std::move(downloads), board_)) {}

ViewServer::~ViewServer() = default;

void ViewServer::Announce() {
  Service& service = impl_->service();
  if (service.num_sockets > 0) asio::post(service.context, [&service] { service.Announce(); });
}

void ViewServer::WaitUntilSent(std::chrono::milliseconds patience) {
  Service& service = impl_->service();
  const auto deadline = std::chrono::steady_clock::now() + patience;
  constexpr std::chrono::milliseconds kPeriod{10};
  while (std::chrono::steady_clock::now() < deadline) {
    auto is_sending = std::make_shared<std::promise<bool>>();
    asio::post(service.context,
               [&service, is_sending] { is_sending->set_value(service.IsSending()); });
    std::future<bool> answer = is_sending->get_future();
    const bool is_known = answer.wait_until(deadline) == std::future_status::ready;
    if (is_known && !answer.get()) return;
    std::this_thread::sleep_for(kPeriod);
  }
}

void ViewServer::SetDownloads(std::vector<ViewDownload> downloads) {
  Service& service = impl_->service();
  asio::post(service.context, [&service, downloads = std::move(downloads)]() mutable {
    service.answers.SetDownloads(std::move(downloads));
  });
}

int ViewServer::port() const {
  return impl_->port();
}

std::string ViewServer::url() const {
  const ViewServerOptions& options = impl_->service().options;
  std::string host = options.host;
  if (host == "0.0.0.0" || host == "::") host = asio::ip::host_name();
  if (host.find(':') != std::string::npos) host = "[" + host + "]";
  std::string url = "http://" + host + ":" + std::to_string(port()) + "/";
  if (!options.token.empty()) url += "?token=" + options.token;
  return url;
}

int ViewServer::num_clients() const {
  return impl_->service().num_pages;
}

int ViewServer::num_connections() const {
  return impl_->service().num_connections;
}

}  // namespace facet
