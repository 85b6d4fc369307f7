// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/mcap_file.h"

#include <algorithm>
#include <array>

#include <zlib.h>

#include "facet/io/errors.h"
#include "facet/recording/byte_reader.h"
#include "facet/recording/decompression.h"
#include "facet/recording/mcap_format.h"

namespace facet {
namespace {

using namespace mcap;

constexpr std::uint64_t kFooter = kRecordHeader + 20;

std::string Text(ByteReader& reader) {
  return std::string(reader.Text(reader.Number<std::uint32_t>()));
}

/// Of zlib, which takes 32-bit lengths; zero for what has no checksum.
std::uint32_t Checksum(ByteSpan bytes) {
  uLong crc = crc32(0, nullptr, 0);
  while (!bytes.empty()) {
    const std::size_t part = std::min<std::size_t>(bytes.size(), 1U << 30);
    crc = crc32(crc, bytes.data(), static_cast<uInt>(part));
    bytes = bytes.subspan(part);
  }
  return static_cast<std::uint32_t>(crc);
}

}  // namespace

McapFile::McapFile(const std::filesystem::path& path) : file_(path) {
  const ByteSpan magic =
      file_.Read(0, std::min<std::uint64_t>(kMagic.size(), file_.size()), content_);
  if (!std::ranges::equal(magic, kMagic)) {
    file_.Fail(0, "this is no MCAP file, or its beginning is damaged; copy it again");
  }
  if (!ReadSummary()) Scan();
  Rewind();
}

void McapFile::Rewind() {
  position_ = kMagic.size();
  chunk_ = {};
}

McapFile::Record McapFile::NextRecord() {
  if (position_ == file_.size()) {
    file_.Fail(position_,
               "the file ends without its footer; it is truncated: `mcap recover` repairs it, or "
               "use the part before with --duration");
  }
  const std::uint64_t left = file_.size() - position_;
  if (left < kRecordHeader) file_.Fail(position_, "the file ends within a record; it is truncated");
  ByteReader reader(file_.Read(position_, kRecordHeader, content_));
  Record record;
  record.offset = position_;
  record.opcode = reader.Number<std::uint8_t>();
  record.size = reader.Number<std::uint64_t>();
  if (record.opcode == 0) file_.Fail(position_, "no record begins here; the file is damaged");
  if (record.size > left - kRecordHeader) {
    file_.Fail(
        position_,
        "a record of " + std::to_string(record.size) + " bytes, but the file has only " +
            std::to_string(left - kRecordHeader) +
            " more; it is truncated or damaged: copy it again, `mcap recover` it, or use the "
            "part before with --duration");
  }
  position_ += kRecordHeader + record.size;
  return record;
}

/// False where there is none that can be used.
bool McapFile::ReadSummary() {
  if (file_.size() < kMagic.size() + kFooter + kMagic.size()) return false;
  try {
    const std::uint64_t footer = file_.size() - kMagic.size() - kFooter;
    ByteReader end(file_.Read(footer, kFooter + kMagic.size(), content_));
    if (end.Number<std::uint8_t>() != kOpFooter || end.Number<std::uint64_t>() != 20) return false;
    const std::uint64_t begin = end.Number<std::uint64_t>();
    if (begin == 0 || begin >= footer) return false;
    position_ = begin;
    std::optional<Record> statistics;  // counts by channel: wanted when all of them are known
    while (position_ < footer) {
      const Record record = NextRecord();
      if (record.opcode == kOpStatistics) statistics = record;
      if (record.opcode == kOpSchema || record.opcode == kOpChannel) AddDefinition(record);
    }
    if (statistics) AddDefinition(*statistics);
  } catch (const InputError& error) {
    warnings_.push_back(std::string(error.what()) + " (in the summary, which is not used)");
    schemas_.clear();
    topics_.clear();
    topic_of_channel_.clear();
    duration_.reset();
    return false;
  }
  return !topics_.empty();
}

/// Reads all messages for the sake of the topics. What is damaged is reported when it is read
/// again.
void McapFile::Scan() {
  Rewind();
  std::optional<Timestamp> first;
  Timestamp last;
  try {
    while (const auto message = Next()) {
      ++topics_[message->topic].num_messages;
      first = std::min(first.value_or(message->received), message->received);
      last = std::max(last, message->received);
    }
    warnings_.push_back(file_.path().string() + ": the file has no summary; it was read twice");
  } catch (const InputError&) {
    if (topics_.empty()) throw;
  }
  if (first) duration_ = last - *first;
}

void McapFile::AddSchema(ByteSpan content) {
  ByteReader reader(content);
  const auto id = reader.Number<std::uint16_t>();
  Schema schema;
  schema.name = Text(reader);
  schema.encoding = Text(reader);
  schemas_[id] = schema;
}

void McapFile::AddChannel(ByteSpan content) {
  ByteReader reader(content);
  const auto id = reader.Number<std::uint16_t>();
  const auto schema = reader.Number<std::uint16_t>();
  if (topic_of_channel_.contains(id)) return;
  Topic topic;
  topic.name = Text(reader);
  topic.encoding = EncodingFromText(Text(reader));
  const auto found = schemas_.find(schema);
  if (found != schemas_.end()) topic.type = Ros1TypeName(found->second.name);
  topic_of_channel_[id] = FindOrAddTopic(topics_, topic);
}

void McapFile::AddStatistics(ByteSpan content) {
  ByteReader reader(content);
  reader.Block(8 + 2 + 4 + 4 + 4 + 4);
  const auto first = reader.Number<std::uint64_t>(), last = reader.Number<std::uint64_t>();
  duration_ =
      Timestamp{static_cast<std::int64_t>(last)} - Timestamp{static_cast<std::int64_t>(first)};
  ByteReader counts(reader.Block(reader.Number<std::uint32_t>()));
  while (counts.remaining() > 0) {
    const auto channel = topic_of_channel_.find(counts.Number<std::uint16_t>());
    const auto num = counts.Number<std::uint64_t>();
    if (channel != topic_of_channel_.end()) topics_[channel->second].num_messages += num;
  }
}

void McapFile::AddDefinition(const Record& record) {
  AddDefinition(record.opcode,
                file_.Read(record.offset + kRecordHeader, record.size, content_),
                record.offset);
}

void McapFile::AddDefinition(std::uint8_t opcode, ByteSpan content, std::uint64_t offset) {
  try {
    if (opcode == kOpSchema) AddSchema(content);
    if (opcode == kOpChannel) AddChannel(content);
    if (opcode == kOpStatistics) AddStatistics(content);
  } catch (const InputError& error) {
    file_.Fail(offset, std::string("a damaged record: it ") + error.what());
  }
}

void McapFile::OpenChunk(const Record& record) {
  const std::uint64_t content = record.offset + kRecordHeader;
  ByteReader reader(file_.Read(content, record.size, content_));
  chunk_offset_ = record.offset;
  try {
    reader.Block(16);  // stamps of the first and last message
    const auto size = reader.Number<std::uint64_t>();
    const auto crc = reader.Number<std::uint32_t>();
    const std::string name = Text(reader);
    const auto compression = CompressionFromText(name);
    if (!compression) throw InputError("compressed with '" + name + "'; lz4 and zstd are known");
    chunk_ =
        Decompress(*compression, reader.Block(reader.Number<std::uint64_t>()), size, decompressed_);
    if (crc != 0 && crc != Checksum(chunk_)) throw InputError("the checksum does not fit");
  } catch (const InputError& error) {
    chunk_ = {};
    file_.Fail(record.offset,
               std::string("a damaged chunk: ") + error.what() +
                   "; copy the file again, or use the part before with --duration");
  }
}

std::optional<Message> McapFile::ToMessage(ByteSpan content, std::uint64_t offset) const {
  ByteReader reader(content);
  const auto channel = topic_of_channel_.find(reader.Number<std::uint16_t>());
  reader.Block(4);  // sequence number
  Message message;
  message.received.ns = static_cast<std::int64_t>(reader.Number<std::uint64_t>());
  reader.Block(8);  // publish time
  if (channel == topic_of_channel_.end()) {
    throw InputError("a message of a channel that the file does not describe");
  }
  message.topic = channel->second;
  message.bytes = reader.Block(reader.remaining());
  message.offset = offset;
  return message;
}

std::optional<Message> McapFile::NextInChunk() {
  while (!chunk_.empty()) {
    try {
      ByteReader reader(chunk_);
      const auto opcode = reader.Number<std::uint8_t>();
      const ByteSpan content = reader.Block(reader.Number<std::uint64_t>());
      chunk_ = chunk_.subspan(reader.position());
      if (opcode == kOpMessage) return ToMessage(content, chunk_offset_);
      AddDefinition(opcode, content, chunk_offset_);
    } catch (const InputError& error) {
      chunk_ = {};
      file_.Fail(chunk_offset_, std::string("a damaged chunk: ") + error.what());
    }
  }
  return std::nullopt;
}

std::optional<Message> McapFile::Next() {
  while (true) {
    if (auto message = NextInChunk()) return message;
    const Record record = NextRecord();
    switch (record.opcode) {
      case kOpDataEnd:
      case kOpFooter:
        position_ = record.offset;  // whoever asks again gets the same answer
        return std::nullopt;
      case kOpChunk:
        OpenChunk(record);
        break;
      case kOpSchema:
      case kOpChannel:
        AddDefinition(record);
        break;
      case kOpMessage:
        try {
          return ToMessage(file_.Read(record.offset + kRecordHeader, record.size, content_),
                           record.offset);
        } catch (const InputError& error) {
          file_.Fail(record.offset, std::string("a damaged message: ") + error.what());
        }
      default:
        break;  // indices, attachments, metadata
    }
  }
}

}  // namespace facet
