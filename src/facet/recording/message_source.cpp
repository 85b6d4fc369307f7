// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/message_source.h"

namespace facet {

std::string Ros1TypeName(const std::string& type) {
  const std::size_t at = type.find("/msg/");
  return at == std::string::npos ? type : type.substr(0, at) + type.substr(at + 4);
}

MessageEncoding EncodingFromText(const std::string& name) {
  if (name == "cdr") return MessageEncoding::kCdr;
  return name == "ros1" ? MessageEncoding::kRos1 : MessageEncoding::kOther;
}

}  // namespace facet
