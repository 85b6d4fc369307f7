// SPDX-License-Identifier: BSD-2-Clause
#include "facet/publish/foxglove_server.h"

#include <deque>
#include <map>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "facet/io/json_file.h"
#include "facet/viewer/view_access.h"

namespace facet {

namespace {

using Json = nlohmann::ordered_json;

constexpr char kMessageData = 1;
constexpr std::size_t kMaxSubscriptions = 1000;

std::string LittleEndian(std::uint64_t value, int num_bytes) {
  std::string bytes;
  for (int i = 0; i < num_bytes; ++i)
    bytes += static_cast<char>(value >> (8 * i) & 0xff);
  return bytes;
}

std::string Advertisement() {
  Json channels = Json::array();
  for (std::size_t i = 0; i < kChannels.size(); ++i) {
    const auto& [topic, schema] = kChannels[i];
    channels.push_back({{"id", i},
                        {"topic", topic},
                        {"encoding", "json"},
                        {"schemaName", schema},
                        {"schema", SchemaText(schema)},
                        {"schemaEncoding", "jsonschema"}});
  }
  return Json{{"op", "advertise"}, {"channels", channels}}.dump();
}

}  // namespace

/// One client, with what it has subscribed to.
class FoxgloveServer::Session : public SocketSession {
 public:
  explicit Session(std::shared_ptr<const Shared> shared) : shared_(std::move(shared)) {
    const Json info = {{"op", "serverInfo"},
                       {"name", shared_->name},
                       {"capabilities", Json::array()},
                       {"supportedEncodings", Json::array()},
                       {"metadata", Json::object()},
                       {"sessionId", shared_->session_id}};
    texts_.push_back(info.dump());
    texts_.push_back(Advertisement());
  }

  std::optional<Frame> Next() override {
    if (!texts_.empty()) {
      const auto text = std::make_shared<const std::string>(std::move(texts_.front()));
      texts_.pop_front();
      return Frame{text, true};
    }
    // In turn, so that a large map does not keep the state waiting.
    auto at = subscriptions_.upper_bound(last_);
    for (std::size_t i = 0; i < subscriptions_.size(); ++i, ++at) {
      if (at == subscriptions_.end()) at = subscriptions_.begin();
      auto& [id, subscription] = *at;
      const auto entry = shared_->boards[subscription.channel].NextAfter(subscription.number);
      if (!entry) continue;
      subscription.number = entry->number;
      last_ = id;
      const std::string head = std::string(1, kMessageData) + LittleEndian(id, 4);
      return Frame{std::make_shared<const std::string>(head + *entry->message), false};
    }
    return std::nullopt;
  }

  // Clients have nothing to say but what they want to have; what is not understood is answered.
  bool Receive(std::string_view bytes, bool is_text) override {
    const Json message = is_text ? ParseJson(bytes) : nlohmann::ordered_json();
    if (!message.is_object() || !message.contains("op")) return Complain("not understood");
    const Json& op = message["op"];
    if (op == "subscribe") return Subscribe(message.value("subscriptions", Json()));
    if (op == "unsubscribe") return Unsubscribe(message.value("subscriptionIds", Json()));
    return Complain("this server does not know the operation " + op.dump());
  }

 private:
  struct Subscription {
    std::size_t channel = 0;
    std::uint64_t number = 0;  // of the newest message that was sent
  };

  bool Subscribe(const Json& wanted) {
    if (!wanted.is_array()) return Complain("subscriptions must be a list");
    for (const Json& item : wanted) {
      if (!item.is_object() || !IsId(item.value("id", Json())) ||
          !IsId(item.value("channelId", Json()))) {
        return Complain("a subscription needs the numbers id and channelId");
      }
      const auto channel = item["channelId"].get<std::size_t>();
      if (channel >= kChannels.size()) {
        Complain("there is no channel " + std::to_string(channel));
      } else if (subscriptions_.size() < kMaxSubscriptions) {
        subscriptions_.try_emplace(item["id"].get<std::uint32_t>(), Subscription{channel});
      }
    }
    return true;
  }

  bool Unsubscribe(const Json& ids) {
    if (!ids.is_array()) return Complain("subscriptionIds must be a list");
    for (const Json& id : ids) {
      if (IsId(id)) subscriptions_.erase(id.get<std::uint32_t>());
    }
    return true;
  }

  static bool IsId(const Json& value) {
    return value.is_number_unsigned() && value.get<std::uint64_t>() <= 0xffffffff;
  }

  // A client that goes on and on sees only the last of them.
  bool Complain(const std::string& text) {
    constexpr std::size_t kMaxTexts = 20;
    constexpr int kError = 2;
    while (texts_.size() >= kMaxTexts)
      texts_.pop_back();
    texts_.push_back(Json{{"op", "status"}, {"level", kError}, {"message", text}}.dump(
        -1, ' ', false, Json::error_handler_t::replace));
    return true;
  }

  const std::shared_ptr<const Shared> shared_;
  std::deque<std::string> texts_;
  std::map<std::uint32_t, Subscription> subscriptions_;  // by the client's number
  std::uint32_t last_ = 0;                               // whose message was sent last
};

FoxgloveServer::FoxgloveServer(std::string name) : shared_(std::make_shared<Shared>()) {
  shared_->name = std::move(name);
  shared_->session_id = RandomToken();
}

SocketProtocol FoxgloveServer::Protocol() const {
  SocketProtocol protocol;
  protocol.names = {"foxglove.websocket.v1", "foxglove.sdk.v1"};
  protocol.origins = {"https://app.foxglove.dev"};
  protocol.make_session = [shared = shared_] { return std::make_unique<Session>(shared); };
  return protocol;
}

void FoxgloveServer::Add(const PublishedMessage& message) {
  const std::string stamp = LittleEndian(static_cast<std::uint64_t>(message.t.ns), 8);
  shared_->boards[static_cast<std::size_t>(message.channel)].Post(message.slot,
                                                                  stamp + message.json);
}

}  // namespace facet
