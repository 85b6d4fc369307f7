// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/message_source.h"

#include <algorithm>

#include "facet/io/errors.h"

namespace facet {

std::size_t FindOrAddTopic(std::vector<Topic>& topics, const Topic& topic) {
  constexpr std::size_t kMaxTopics = 10000;
  const auto same = std::ranges::find_if(topics, [&](const Topic& other) {
    return other.name == topic.name && other.type == topic.type && other.encoding == topic.encoding;
  });
  const auto index = static_cast<std::size_t>(same - topics.begin());
  if (same != topics.end()) return index;
  if (topics.size() == kMaxTopics) throw InputError("has more than 10000 topics");
  topics.push_back(topic);
  topics.back().num_messages = 0;
  return index;
}

std::string Ros1TypeName(const std::string& type) {
  const std::size_t at = type.find("/msg/");
  return at == std::string::npos ? type : type.substr(0, at) + type.substr(at + 4);
}

MessageEncoding EncodingFromText(const std::string& name) {
  if (name == "cdr") return MessageEncoding::kCdr;
  return name == "ros1" ? MessageEncoding::kRos1 : MessageEncoding::kOther;
}

}  // namespace facet
