// SPDX-License-Identifier: BSD-2-Clause
// ROS 1 bag, version 2.0 (http://wiki.ros.org/Bags/Format/2.0): records of a header with named
// fields and data; messages mostly in chunks, compressed with lz4 or bz2.
#pragma once

#include <filesystem>
#include <map>
#include <string_view>

#include "facet/recording/message_source.h"
#include "facet/recording/random_access_file.h"

namespace facet {

/// Keeps one chunk in memory. Not thread-safe.
class Ros1Bag : public MessageSource {
 public:
  /// Throws InputError when the file cannot be read, is no such bag or has no message. Without an
  /// index (`rosbag record` was killed) the file is read once to find its topics.
  explicit Ros1Bag(const std::filesystem::path& path);

  std::string Kind() const override { return "ROS 1 bag"; }
  std::string PlaceOf(const Message& message) const override {
    return file_.PlaceOf(message.offset);
  }
  const std::vector<Topic>& topics() const override { return topics_; }
  std::optional<Duration> IndexedDuration() const override { return duration_; }
  std::optional<Message> Next() override;
  void Rewind() override;
  std::vector<std::string> Warnings() const override { return warnings_; }

 private:
  using Fields = std::map<std::string, std::string, std::less<>>;
  struct Record {
    std::uint64_t offset = 0;  ///< of the header's length
    Fields fields;
    std::uint64_t data = 0;  ///< offset of the data
    std::uint32_t data_size = 0;
    int op = -1;
  };

  static Fields ParseFields(ByteSpan header);
  Record ReadRecord(std::uint64_t offset);
  void ReadBagHeader();
  bool ReadIndex();
  void Scan();
  void AddConnection(const Fields& fields, ByteSpan data);
  void AddChunkCounts(const Record& record);
  void OpenChunk(const Record& record);
  std::optional<Message> NextInChunk();
  Message ToMessage(const Fields& fields, ByteSpan data, std::uint64_t offset) const;

  RandomAccessFile file_;
  std::uint64_t first_record_ = 0, index_ = 0, position_ = 0;
  std::uint64_t announced_index_ = 0;  ///< where the index should be and is not; 0: fine or none
  std::vector<std::uint8_t> head_, data_, decompressed_;
  ByteSpan chunk_;
  std::uint64_t chunk_offset_ = 0;
  std::map<std::uint32_t, std::size_t> topic_of_connection_;
  std::vector<Topic> topics_;
  std::optional<Timestamp> first_, last_;
  std::optional<Duration> duration_;
  std::vector<std::string> warnings_;
};

}  // namespace facet
