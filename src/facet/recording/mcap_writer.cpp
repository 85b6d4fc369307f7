// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/mcap_writer.h"

#include <algorithm>
#include <system_error>

#include <zlib.h>
#include <zstd.h>

#include "facet/base/check.h"
#include "facet/io/errors.h"
#include "facet/recording/mcap_format.h"

namespace facet {
namespace {

using namespace mcap;

constexpr std::size_t kChunkSize = 4 << 20;
std::string Magic() {
  return {kMagic.begin(), kMagic.end()};
}

template <class T>
std::string Raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof(T)};
}
std::string Raw(Timestamp t) {
  return Raw(static_cast<std::uint64_t>(t.ns));
}

std::string Sized(const std::string& bytes) {
  return Raw(static_cast<std::uint32_t>(bytes.size())) + bytes;
}

std::string Record(Opcode opcode, const std::string& content) {
  return std::string(1, static_cast<char>(opcode)) +
         Raw(static_cast<std::uint64_t>(content.size())) + content;
}

std::string Pairs(const std::map<std::uint16_t, std::uint64_t>& values) {
  std::string bytes;
  for (const auto& [key, value] : values)
    bytes += Raw(key) + Raw(value);
  return Sized(bytes);
}

std::string Zstd(const std::string& bytes) {
  constexpr int kLevel = 1;  // images hardly become smaller with more
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size =
      ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kLevel);
  FACET_CHECK(ZSTD_isError(size) == 0) << ZSTD_getErrorName(size);
  out.resize(size);
  return out;
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& file,
                       Compression compression,
                       const std::string& profile)
    : file_(file), compression_(compression), stream_(Partial(), std::ios::binary) {
  FACET_CHECK(compression == Compression::kNone || compression == Compression::kZstd)
      << "MCAP files are written with zstd or without compression";
  Write(Magic() + Record(kOpHeader, Sized(profile) + Sized("facet")));
}

McapWriter::~McapWriter() {
  if (is_complete_) return;
  stream_.close();
  if (keeps_partial_) return;
  std::error_code error;
  std::filesystem::remove(Partial(), error);
}

std::filesystem::path McapWriter::Partial() const {
  return file_.string() + ".partial";
}

const char* McapWriter::CompressionName() const {
  return compression_ == Compression::kZstd ? "zstd" : "";
}

void McapWriter::Write(const std::string& bytes) {
  stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!stream_) {
    throw OutputError(file_.string() + ": cannot be written (no such folder, or disk full?)");
  }
  position_ += bytes.size();
}

std::uint16_t McapWriter::AddChannel(const std::string& topic,
                                     const std::string& type,
                                     const std::string& definition) {
  std::string ros2_type = type;
  ros2_type.insert(ros2_type.find('/') + 1, "msg/");
  return AddChannel({topic, "cdr", ros2_type, "ros2msg", definition});
}

std::uint16_t McapWriter::AddChannel(const McapChannel& added) {
  const std::uint16_t channel = num_channels_++;
  const auto schema = static_cast<std::uint16_t>(channel + 1);  // zero means none
  const std::string records =
      Record(kOpSchema,
             Raw(schema) + Sized(added.schema) + Sized(added.schema_encoding) +
                 Sized(added.definition)) +
      Record(kOpChannel,
             Raw(channel) + Raw(schema) + Sized(added.topic) + Sized(added.encoding) + Sized(""));
  definitions_ += records;
  chunk_ += records;
  return channel;
}

void McapWriter::AddMessage(std::uint16_t channel,
                            Timestamp t,
                            std::span<const std::uint8_t> bytes) {
  FACET_CHECK(channel < num_channels_) << "no channel " << channel;
  const bool is_first = message_indices_.empty();
  open_.first = is_first ? t : std::min(open_.first, t);
  open_.last = is_first ? t : std::max(open_.last, t);
  message_indices_[channel] += Raw(t) + Raw(static_cast<std::uint64_t>(chunk_.size()));
  const std::uint64_t number = counts_[channel]++;
  const std::string head = Raw(channel) + Raw(static_cast<std::uint32_t>(number)) + Raw(t) + Raw(t);
  chunk_ += static_cast<char>(kOpMessage);
  chunk_ += Raw(static_cast<std::uint64_t>(head.size() + bytes.size())) + head;
  chunk_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (chunk_.size() >= kChunkSize) WriteChunk();
}

void McapWriter::WriteChunk() {
  if (chunk_.empty()) return;
  const auto crc = static_cast<std::uint32_t>(crc32(crc32(0, nullptr, 0),
                                                    reinterpret_cast<const Bytef*>(chunk_.data()),
                                                    static_cast<uInt>(chunk_.size())));
  const std::string compressed = compression_ == Compression::kZstd ? Zstd(chunk_) : std::string();
  const std::string& stored = compression_ == Compression::kZstd ? compressed : chunk_;
  open_.offset = position_;
  open_.raw_size = chunk_.size();
  open_.compressed_size = stored.size();
  const std::string head = Raw(open_.first) + Raw(open_.last) + Raw(open_.raw_size) + Raw(crc) +
                           Sized(CompressionName()) + Raw(open_.compressed_size);
  open_.size = kRecordHeader + head.size() + stored.size();
  Write(std::string(1, static_cast<char>(kOpChunk)) + Raw(open_.size - kRecordHeader) + head);
  Write(stored);
  WriteMessageIndices(open_);
  chunks_.push_back(open_);
  open_ = {};
  chunk_.clear();
}

void McapWriter::EndChunk() {
  WriteChunk();
  stream_.flush();
}

void McapWriter::WriteMessageIndices(ChunkIndex& index) {
  const std::uint64_t begin = position_;
  for (const auto& [channel, entries] : message_indices_) {
    index.index_offsets[channel] = position_;
    Write(Record(kOpMessageIndex, Raw(channel) + Sized(entries)));
  }
  index.index_size = position_ - begin;
  message_indices_.clear();
}

std::string McapWriter::Summary() const {
  Timestamp first, last;
  std::uint64_t num_messages = 0;
  for (const ChunkIndex& chunk : chunks_) {
    const bool is_first = &chunk == &chunks_.front();
    first = is_first ? chunk.first : std::min(first, chunk.first);
    last = is_first ? chunk.last : std::max(last, chunk.last);
  }
  for (const auto& [channel, count] : counts_)
    num_messages += count;
  constexpr std::uint32_t kNone = 0;  // attachments and metadata
  std::string summary =
      definitions_ +
      Record(kOpStatistics,
             Raw(num_messages) + Raw(num_channels_) + Raw(std::uint32_t{num_channels_}) +
                 Raw(kNone) + Raw(kNone) + Raw(static_cast<std::uint32_t>(chunks_.size())) +
                 Raw(first) + Raw(last) + Pairs(counts_));
  for (const ChunkIndex& chunk : chunks_) {
    summary +=
        Record(kOpChunkIndex,
               Raw(chunk.first) + Raw(chunk.last) + Raw(chunk.offset) + Raw(chunk.size) +
                   Pairs(chunk.index_offsets) + Raw(chunk.index_size) + Sized(CompressionName()) +
                   Raw(chunk.compressed_size) + Raw(chunk.raw_size));
  }
  return summary;
}

void McapWriter::Commit() {
  WriteChunk();
  Write(Record(kOpDataEnd, Raw(std::uint32_t{0})));
  const std::uint64_t summary = position_;
  Write(Summary());
  Write(Record(kOpFooter, Raw(summary) + Raw(std::uint64_t{0}) + Raw(std::uint32_t{0})) + Magic());
  stream_.close();
  std::error_code error;
  if (stream_) std::filesystem::rename(Partial(), file_, error);
  if (!stream_ || error) {
    throw OutputError(file_.string() + ": cannot be written (disk full?)");
  }
  is_complete_ = true;
}

}  // namespace facet
