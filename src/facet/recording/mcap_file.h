// SPDX-License-Identifier: BSD-2-Clause
// MCAP (https://mcap.dev/spec): records of opcode, length and content; messages mostly in chunks,
// compressed with lz4 or zstd.
#pragma once

#include <filesystem>
#include <map>

#include "facet/recording/message_source.h"
#include "facet/recording/random_access_file.h"

namespace facet {

/// Keeps one chunk in memory. Not thread-safe.
class McapFile : public MessageSource {
 public:
  /// Throws InputError when the file cannot be read or is no MCAP. A missing or damaged summary is
  /// no error: the file is then read once to find its topics.
  explicit McapFile(const std::filesystem::path& path);

  std::string Kind() const override { return "MCAP"; }
  std::string PlaceOf(const Message& message) const override {
    return file_.PlaceOf(message.offset);
  }
  const std::vector<Topic>& topics() const override { return topics_; }
  std::optional<Duration> IndexedDuration() const override { return duration_; }
  std::optional<Message> Next() override;
  void Rewind() override;
  std::vector<std::string> Warnings() const override { return warnings_; }

 private:
  struct Record {
    std::uint8_t opcode = 0;
    std::uint64_t offset = 0;  ///< of the opcode
    std::uint64_t size = 0;    ///< of the content
  };
  struct Schema {
    std::string name, encoding;
  };

  Record NextRecord();
  bool ReadSummary();
  void Scan();
  void OpenChunk(const Record& record);
  std::optional<Message> NextInChunk();
  void AddSchema(ByteSpan content);
  void AddChannel(ByteSpan content);
  void AddStatistics(ByteSpan content);
  void AddDefinition(const Record& record);
  void AddDefinition(std::uint8_t opcode, ByteSpan content, std::uint64_t offset);
  std::optional<Message> ToMessage(ByteSpan content, std::uint64_t offset) const;

  RandomAccessFile file_;
  std::uint64_t position_ = 0;
  std::vector<std::uint8_t> content_, decompressed_;
  ByteSpan chunk_;  ///< what is left of the records of the open chunk
  std::uint64_t chunk_offset_ = 0;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, std::size_t> topic_of_channel_;
  std::vector<Topic> topics_;
  std::optional<Duration> duration_;
  std::vector<std::string> warnings_;
};

}  // namespace facet
