// SPDX-License-Identifier: BSD-2-Clause
// What a client hears and may say; over a real socket, and with Foxglove's own client, it is tested
// by viewer/foxglove/test.mjs.
#include "facet/publish/foxglove_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace facet {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

constexpr Timestamp kLogTime{0x0102030405060708};

class FoxgloveServerTest : public ::testing::Test {
 protected:
  FoxgloveServerTest() : session_(server_.Protocol().make_session()) {}

  Json NextText() {
    const auto frame = session_->Next();
    return frame && frame->is_text ? Json::parse(*frame->bytes) : Json();
  }
  std::string NextData() {
    const auto frame = session_->Next();
    return frame && !frame->is_text ? *frame->bytes : "";
  }
  void Say(const std::string& text) { EXPECT_TRUE(session_->Receive(text, true)); }
  void Subscribe(int id, Channel channel) {
    Say(R"({"op":"subscribe","subscriptions":[{"id":)" + std::to_string(id) + R"(,"channelId":)" +
        std::to_string(static_cast<int>(channel)) + "}]}");
  }
  void Add(Channel channel, const std::string& slot, const std::string& json) {
    server_.Add({channel, slot, kLogTime, json});
  }

  FoxgloveServer server_{"facet test"};
  std::unique_ptr<SocketSession> session_;
};

TEST_F(FoxgloveServerTest, BeginsWithItsNameAndChannels) {
  const Json info = NextText();
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["name"], "facet test");
  const Json channels = NextText()["channels"];
  ASSERT_EQ(channels.size(), kChannels.size());
  EXPECT_EQ(channels[1]["topic"], "/facet/pose");
  EXPECT_EQ(channels[1]["schemaName"], "foxglove.PoseInFrame");
  EXPECT_EQ(Json::parse(channels[1]["schema"].get<std::string>())["title"], "foxglove.PoseInFrame");
  EXPECT_FALSE(session_->Next());
}

TEST_F(FoxgloveServerTest, SendsWhatIsSubscribedAndTheNewestOfBefore) {
  NextText();
  NextText();
  Add(Channel::kPose, "", "old");
  Add(Channel::kPose, "", "new");
  Add(Channel::kMap, "a", "part a");
  Add(Channel::kMap, "b", "part b");
  EXPECT_FALSE(session_->Next()) << "nobody has asked";
  Subscribe(0x0a0b, Channel::kPose);
  const std::string head("\x01\x0b\x0a\x00\x00\x08\x07\x06\x05\x04\x03\x02\x01", 13);
  EXPECT_EQ(NextData(), head + "new");
  EXPECT_FALSE(session_->Next());
  Subscribe(3, Channel::kMap);
  EXPECT_THAT(NextData(), HasSubstr("part a"));
  Add(Channel::kPose, "", "newer");
  EXPECT_EQ(NextData(), head + "newer") << "in turn";
  EXPECT_THAT(NextData(), HasSubstr("part b"));
  Say(R"({"op":"unsubscribe","subscriptionIds":[3]})");
  Add(Channel::kMap, "a", "part a again");
  EXPECT_FALSE(session_->Next());
}

TEST_F(FoxgloveServerTest, AnswersWhatItDoesNotUnderstand) {
  NextText();
  NextText();
  for (const char* text :
       {"",
        "nonsense",
        "[1,2]",
        "{}",
        R"({"op":7})",
        R"({"op":"advertise","channels":[]})",
        R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":[1]})",
        R"({"op":"subscribe","subscriptions":[{"id":"1","channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":99}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":0}]})",
        R"({"op":"unsubscribe","subscriptionIds":7})"}) {
    Say(text);
    const Json status = NextText();
    EXPECT_EQ(status["op"], "status") << text;
    EXPECT_EQ(status["level"], 2) << text;
    EXPECT_FALSE(session_->Next()) << text;
  }
  EXPECT_TRUE(session_->Receive("\x01\xff", false));
  EXPECT_EQ(NextText()["op"], "status");
  for (int i = 0; i < 1000; ++i)
    Say("nonsense");
  int num_answers = 0;
  while (session_->Next())
    ++num_answers;
  EXPECT_LE(num_answers, 20);
}

TEST_F(FoxgloveServerTest, SpeaksBothNamesOfTheProtocol) {
  EXPECT_THAT(server_.Protocol().names,
              ::testing::ElementsAre("foxglove.websocket.v1", "foxglove.sdk.v1"));
}

}  // namespace
}  // namespace facet
