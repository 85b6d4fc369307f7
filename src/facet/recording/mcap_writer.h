// SPDX-License-Identifier: BSD-2-Clause
// Writes MCAP files (https://mcap.dev/spec), with index and summary.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "facet/recording/decompression.h"
#include "facet/recording/message_source.h"

namespace facet {

/// What an MCAP file says of a channel.
struct McapChannel {
  std::string topic;
  std::string encoding;         ///< of the messages, for example json
  std::string schema;           ///< name of their type
  std::string schema_encoding;  ///< for example jsonschema
  std::string definition;       ///< the schema itself
};

/// Keeps one chunk in memory, and 60 bytes for each one written. The file has its name when it is
/// complete; before, it is called FILE.partial. Not thread-safe.
class McapWriter {
 public:
  /// `compression` is kNone or kZstd (CHECKed). `profile`: what the header says of the channels,
  /// empty: nothing. All functions throw OutputError when the file cannot be written.
  McapWriter(const std::filesystem::path& file,
             Compression compression,
             const std::string& profile = "ros2");
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;
  ~McapWriter();  ///< removes what is not complete, unless KeepPartial

  /// A recording that cannot be completed stays as FILE.partial, with all chunks that were written.
  void KeepPartial() { keeps_partial_ = true; }

  /// Returns the number of the channel.
  std::uint16_t AddChannel(const McapChannel& channel);

  /// The same for ROS 2 messages. `type` as ROS 1 writes it, for example sensor_msgs/Image;
  /// `definition` as ROS 2 does.
  std::uint16_t AddChannel(const std::string& topic,
                           const std::string& type,
                           const std::string& definition);

  void AddMessage(std::uint16_t channel, Timestamp t, std::span<const std::uint8_t> bytes);

  /// What was added is in the file from now on, where whoever recovers files without a summary
  /// finds it.
  void EndChunk();

  /// Writes the last chunk and the summary, and gives the file its name.
  void Commit();

 private:
  struct ChunkIndex {
    Timestamp first, last;
    std::uint64_t offset = 0, size = 0;
    std::map<std::uint16_t, std::uint64_t> index_offsets;
    std::uint64_t index_size = 0, compressed_size = 0, raw_size = 0;
  };

  std::filesystem::path Partial() const;
  void Write(const std::string& bytes);
  void WriteChunk();
  void WriteMessageIndices(ChunkIndex& index);
  std::string Summary() const;
  const char* CompressionName() const;

  std::filesystem::path file_;
  Compression compression_;
  std::ofstream stream_;
  std::uint64_t position_ = 0;
  std::string definitions_;  ///< records of all schemas and channels
  std::uint16_t num_channels_ = 0;
  std::string chunk_;
  ChunkIndex open_;
  std::map<std::uint16_t, std::string> message_indices_;  ///< of the open chunk, by channel
  std::vector<ChunkIndex> chunks_;
  std::map<std::uint16_t, std::uint64_t> counts_;
  bool is_complete_ = false, keeps_partial_ = false;
};

}  // namespace facet
