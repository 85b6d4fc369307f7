// SPDX-License-Identifier: BSD-2-Clause
#include "facet/publish/mcap_recorder.h"

namespace facet {

McapRecorder::McapRecorder(const std::filesystem::path& file)
    : writer_(file, Compression::kZstd, "") {
  writer_.KeepPartial();
  for (std::size_t i = 0; i < kChannels.size(); ++i) {
    const auto& [topic, schema] = kChannels[i];
    channels_[i] = writer_.AddChannel({std::string(topic),
                                       "json",
                                       std::string(schema),
                                       "jsonschema",
                                       std::string(SchemaText(schema))});
  }
}

void McapRecorder::Add(const PublishedMessage& message) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(message.json.data());
  writer_.AddMessage(channels_[static_cast<std::size_t>(message.channel)],
                     message.t,
                     {bytes, message.json.size()});
  if (message.t < chunk_end_) return;
  constexpr Duration kSecond{1'000'000'000};
  chunk_end_ = message.t + kSecond;
  writer_.EndChunk();
}

}  // namespace facet
