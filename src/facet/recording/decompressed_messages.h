// SPDX-License-Identifier: BSD-2-Clause
// Bags of ROS 2 whose messages are compressed one by one (rosbag2's compression mode "message").
#pragma once

#include <memory>
#include <utility>

#include "facet/recording/message_source.h"

namespace facet {

/// Decompresses the messages in CDR that are compressed with zstd, which shows by their first
/// bytes, and lets all others through. One that is damaged comes without bytes. Not thread-safe.
class DecompressedMessages : public MessageSource {
 public:
  explicit DecompressedMessages(std::unique_ptr<MessageSource> source)
      : source_(std::move(source)) {}

  std::string Kind() const override { return source_->Kind(); }
  std::string PlaceOf(const Message& message) const override { return source_->PlaceOf(message); }
  const std::vector<Topic>& topics() const override { return source_->topics(); }
  std::optional<Duration> IndexedDuration() const override { return source_->IndexedDuration(); }
  std::optional<Message> Next() override;
  void Rewind() override { source_->Rewind(); }
  std::vector<std::string> Warnings() const override { return source_->Warnings(); }

 private:
  std::unique_ptr<MessageSource> source_;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace facet
