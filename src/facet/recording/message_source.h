// SPDX-License-Identifier: BSD-2-Clause
// A bag as a stream of messages, still as bytes. Knows nothing of what is in them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "facet/base/types.h"

namespace facet {

/// How the fields of messages are written.
enum class MessageEncoding { kRos1, kCdr, kOther };

struct Topic {
  std::string name;
  std::string type;  ///< as ROS 1 writes it: sensor_msgs/Image
  MessageEncoding encoding = MessageEncoding::kOther;
  std::uint64_t num_messages = 0;  ///< 0: not known
};

/// A message in the order of the file.
struct Message {
  std::size_t topic = 0;                ///< index into the topics of the source
  Timestamp received;                   ///< when the recorder got it
  std::span<const std::uint8_t> bytes;  ///< valid until the next call
  std::uint64_t offset = 0;  ///< in the file, of its chunk if it is in one; a row in a database
};

/// Not thread-safe.
class MessageSource {
 public:
  MessageSource() = default;
  MessageSource(const MessageSource&) = delete;
  MessageSource& operator=(const MessageSource&) = delete;
  virtual ~MessageSource() = default;

  /// "ROS 1 bag", "MCAP" and so on.
  virtual std::string Kind() const = 0;

  /// Where the message that was read last lies, for messages to the user: "a.bag: at byte 17".
  virtual std::string PlaceOf(const Message& message) const = 0;

  /// Known from the beginning: from the file's index, or else because it was read once. Empty for
  /// a file without messages.
  virtual const std::vector<Topic>& topics() const = 0;

  /// From the first to the last message as the index says, empty without one.
  virtual std::optional<Duration> IndexedDuration() const = 0;

  /// Empty at the end, and whenever it is called again there. Throws InputError with file and
  /// offset where the file is damaged.
  virtual std::optional<Message> Next() = 0;

  virtual void Rewind() = 0;

  /// What is odd, for warnings.
  virtual std::vector<std::string> Warnings() const { return {}; }
};

/// The index of the topic with the same name, type and encoding: several publishers may have one
/// topic. Where there is none, it is added, without messages. Throws InputError, without a place,
/// when there are more topics than any recording has (10000).
std::size_t FindOrAddTopic(std::vector<Topic>& topics, const Topic& topic);

/// sensor_msgs/msg/Image to sensor_msgs/Image.
std::string Ros1TypeName(const std::string& type);

/// "cdr" and "ros1".
MessageEncoding EncodingFromText(const std::string& name);

}  // namespace facet
