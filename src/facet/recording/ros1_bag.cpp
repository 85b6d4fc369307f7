// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/ros1_bag.h"

#include <algorithm>
#include <cstring>

#include "facet/io/errors.h"
#include "facet/recording/byte_reader.h"
#include "facet/recording/decompression.h"

namespace facet {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint32_t kMaxHeader = 1 << 20;
constexpr const char* kRepair =
    "; copy the file again, repair it with `rosbag reindex`, or use the part before with "
    "--duration";

enum Op { kOpMessage = 2, kOpBagHeader = 3, kOpChunk = 5, kOpChunkInfo = 6, kOpConnection = 7 };

template <class Fields>
const std::string& Require(const Fields& fields, std::string_view name) {
  const auto found = fields.find(name);
  if (found == fields.end()) {
    throw InputError("a record without the field '" + std::string(name) + "'");
  }
  return found->second;
}

template <class T, class Fields>
T RequireNumber(const Fields& fields, std::string_view name) {
  const std::string& text = Require(fields, name);
  if (text.size() != sizeof(T)) {
    throw InputError("the field '" + std::string(name) + "' has " + std::to_string(text.size()) +
                     " bytes");
  }
  T value;
  std::memcpy(&value, text.data(), sizeof(T));
  return value;
}

/// Seconds and nanoseconds, 32 bits each.
template <class Fields>
Timestamp RequireTime(const Fields& fields, std::string_view name) {
  const auto bits = RequireNumber<std::uint64_t>(fields, name);
  const auto s = static_cast<std::int64_t>(bits & 0xFFFFFFFFU);
  const auto ns = static_cast<std::int64_t>(bits >> 32);
  return {s * 1000000000 + ns};
}

}  // namespace

Ros1Bag::Ros1Bag(const std::filesystem::path& path) : file_(path) {
  ByteReader magic(file_.Read(0, std::min<std::uint64_t>(kMagic.size(), file_.size()), head_));
  if (magic.Text(magic.remaining()) != kMagic) {
    file_.Fail(
        0,
        "this is no ROS 1 bag of version 2.0, or its beginning is damaged; copy it again, or "
        "convert older ones with `rosbag fix`");
  }
  ReadBagHeader();
  if (!ReadIndex()) Scan();
  if (first_ && last_) duration_ = *last_ - *first_;
  Rewind();
}

void Ros1Bag::Rewind() {
  position_ = first_record_;
  chunk_ = {};
}

Ros1Bag::Fields Ros1Bag::ParseFields(ByteSpan header) {
  Fields fields;
  ByteReader reader(header);
  while (reader.remaining() > 0) {
    const std::string_view field = reader.Text(reader.Number<std::uint32_t>());
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) throw InputError("a header field without '='");
    fields.insert_or_assign(std::string(field.substr(0, equals)),
                            std::string(field.substr(equals + 1)));
  }
  return fields;
}

Ros1Bag::Record Ros1Bag::ReadRecord(std::uint64_t offset) {
  Record record;
  record.offset = offset;
  const auto number = [&](std::uint64_t at) {
    return ByteReader(file_.Read(at, 4, head_)).Number<std::uint32_t>();
  };
  const std::uint32_t header_size = number(offset);
  if (header_size > kMaxHeader) {
    file_.Fail(offset, "no record begins here; the file is damaged" + std::string(kRepair));
  }
  const ByteSpan header = file_.Read(offset + 4, header_size, head_);
  try {
    record.fields = ParseFields(header);
    const std::string& op = Require(record.fields, "op");
    record.op = op.size() == 1 ? static_cast<unsigned char>(op[0]) : -1;
  } catch (const InputError& error) {
    file_.Fail(offset, std::string("a damaged record: ") + error.what() + kRepair);
  }
  record.data_size = number(offset + 4 + header_size);
  record.data = offset + 8 + header_size;
  if (record.data_size > file_.size() - record.data) {
    file_.Fail(offset,
               "a record of " + std::to_string(record.data_size) +
                   " bytes, but the file has only " + std::to_string(file_.size() - record.data) +
                   " more; it is truncated or damaged" + kRepair);
  }
  return record;
}

void Ros1Bag::ReadBagHeader() {
  const Record record = ReadRecord(kMagic.size());
  if (record.op != kOpBagHeader) file_.Fail(record.offset, "the bag header is missing");
  try {
    index_ = RequireNumber<std::uint64_t>(record.fields, "index_pos");
    const auto encryptor = record.fields.find("encryptor");
    if (encryptor != record.fields.end() && !encryptor->second.empty()) {
      throw InputError("the bag is encrypted; decrypt it with `rosbag decrypt`");
    }
  } catch (const InputError& error) {
    file_.Fail(record.offset, error.what());
  }
  first_record_ = record.data + record.data_size;
}

/// False where there is none that can be used.
bool Ros1Bag::ReadIndex() {
  if (index_ < first_record_ || index_ >= file_.size()) {
    announced_index_ = index_;
    index_ = file_.size();
    return false;
  }
  try {
    for (std::uint64_t at = index_; at < file_.size();) {
      const Record record = ReadRecord(at);
      if (record.op == kOpConnection) {
        AddConnection(record.fields, file_.Read(record.data, record.data_size, data_));
      }
      if (record.op == kOpChunkInfo) AddChunkCounts(record);
      at = record.data + record.data_size;
    }
  } catch (const InputError& error) {
    warnings_.push_back(std::string(error.what()) + " (in the index, which is not used)");
    topics_.clear();
    topic_of_connection_.clear();
    first_.reset();
    last_.reset();
    return false;
  }
  return !topics_.empty();
}

void Ros1Bag::AddChunkCounts(const Record& record) {
  const Timestamp first = RequireTime(record.fields, "start_time");
  const Timestamp last = RequireTime(record.fields, "end_time");
  first_ = std::min(first_.value_or(first), first);
  last_ = std::max(last_.value_or(last), last);
  ByteReader counts(file_.Read(record.data, record.data_size, data_));
  while (counts.remaining() > 0) {
    const auto connection = topic_of_connection_.find(counts.Number<std::uint32_t>());
    const auto num = counts.Number<std::uint32_t>();
    if (connection != topic_of_connection_.end()) topics_[connection->second].num_messages += num;
  }
}

/// Reads all messages for the sake of the topics. What is damaged is reported when it is read
/// again.
void Ros1Bag::Scan() {
  Rewind();
  try {
    while (const auto message = Next()) {
      ++topics_[message->topic].num_messages;
      first_ = std::min(first_.value_or(message->received), message->received);
      last_ = std::max(last_.value_or(message->received), message->received);
    }
    warnings_.push_back(file_.path().string() +
                        ": the bag has no index (`rosbag reindex` writes one); it was read twice");
  } catch (const InputError&) {
    if (topics_.empty()) throw;
  }
}

void Ros1Bag::AddConnection(const Fields& fields, ByteSpan data) {
  const auto id = RequireNumber<std::uint32_t>(fields, "conn");
  if (topic_of_connection_.contains(id)) return;
  const Fields connection = ParseFields(data);
  Topic topic;
  topic.name = Require(fields, "topic");
  topic.type = Require(connection, "type");
  topic.encoding = MessageEncoding::kRos1;
  topic_of_connection_[id] = FindOrAddTopic(topics_, topic);
}

void Ros1Bag::OpenChunk(const Record& record) {
  chunk_offset_ = record.offset;
  const ByteSpan data = file_.Read(record.data, record.data_size, data_);
  try {
    const std::string& name = Require(record.fields, "compression");
    const auto compression = CompressionFromText(name);
    if (!compression) throw InputError("compressed with '" + name + "'; lz4 and bz2 are known");
    chunk_ = Decompress(
        *compression, data, RequireNumber<std::uint32_t>(record.fields, "size"), decompressed_);
  } catch (const InputError& error) {
    chunk_ = {};
    file_.Fail(record.offset, std::string("a damaged chunk: ") + error.what() + kRepair);
  }
}

Message Ros1Bag::ToMessage(const Fields& fields, ByteSpan data, std::uint64_t offset) const {
  const auto connection = topic_of_connection_.find(RequireNumber<std::uint32_t>(fields, "conn"));
  if (connection == topic_of_connection_.end()) {
    throw InputError("a message of a connection that the bag does not describe");
  }
  Message message;
  message.topic = connection->second;
  message.received = RequireTime(fields, "time");
  message.bytes = data;
  message.offset = offset;
  return message;
}

std::optional<Message> Ros1Bag::NextInChunk() {
  while (!chunk_.empty()) {
    try {
      ByteReader reader(chunk_);
      const Fields fields = ParseFields(reader.Block(reader.Number<std::uint32_t>()));
      const ByteSpan data = reader.Block(reader.Number<std::uint32_t>());
      chunk_ = chunk_.subspan(reader.position());
      const auto op = RequireNumber<std::uint8_t>(fields, "op");
      if (op == kOpMessage) return ToMessage(fields, data, chunk_offset_);
      if (op == kOpConnection) AddConnection(fields, data);
    } catch (const InputError& error) {
      chunk_ = {};
      file_.Fail(chunk_offset_, std::string("a damaged chunk: ") + error.what() + kRepair);
    }
  }
  return std::nullopt;
}

std::optional<Message> Ros1Bag::Next() {
  while (true) {
    if (auto message = NextInChunk()) return message;
    if (position_ >= index_) {
      if (announced_index_ > 0) {
        file_.Fail(position_,
                   "the file ends here, before its index at byte " +
                       std::to_string(announced_index_) + "; it is truncated" + kRepair);
      }
      return std::nullopt;
    }
    const Record record = ReadRecord(position_);
    position_ = record.data + record.data_size;
    if (record.op == kOpChunk) OpenChunk(record);
    try {
      if (record.op == kOpConnection) {
        AddConnection(record.fields, file_.Read(record.data, record.data_size, data_));
      } else if (record.op == kOpMessage) {
        return ToMessage(
            record.fields, file_.Read(record.data, record.data_size, data_), record.offset);
      }
    } catch (const InputError& error) {
      file_.Fail(record.offset, std::string("a damaged record: ") + error.what() + kRepair);
    }
  }
}

}  // namespace facet
