// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/recording/test_bags.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

#include <bzlib.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

namespace facet {
namespace {

template <class T>
std::string Raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof(T)};
}

std::string Sized(const std::string& bytes) {
  return Raw(static_cast<std::uint32_t>(bytes.size())) + bytes;
}

/// Numbers of the topics in the order in which they appear.
std::map<std::string, std::uint16_t> NumberTopics(const std::vector<TestMessage>& messages) {
  std::map<std::string, std::uint16_t> numbers;
  for (const TestMessage& message : messages)
    numbers.emplace(message.topic, static_cast<std::uint16_t>(numbers.size()));
  return numbers;
}

const TestMessage& FirstOf(const std::vector<TestMessage>& messages, const std::string& topic) {
  return *std::ranges::find(messages, topic, &TestMessage::topic);
}

std::string CompressionName(Compression compression, const char* none) {
  switch (compression) {
    case Compression::kLz4:
      return "lz4";
    case Compression::kBz2:
      return "bz2";
    case Compression::kZstd:
      return "zstd";
    default:
      return none;
  }
}

// ----------------------------------------------------------------------------------- ROS 1 bag

std::string Ros1Record(const std::vector<std::pair<std::string, std::string>>& fields,
                       const std::string& data) {
  std::string header;
  for (const auto& [name, value] : fields)
    header += Sized(name + "=" + value);
  return Sized(header) + Sized(data);
}

std::string Ros1Time(Timestamp t) {
  return Raw(static_cast<std::uint32_t>(t.ns / 1000000000)) +
         Raw(static_cast<std::uint32_t>(t.ns % 1000000000));
}

std::string Ros1Connection(std::uint32_t id, const TestMessage& message) {
  return Ros1Record({{"op", "\x07"}, {"conn", Raw(id)}, {"topic", message.topic}},
                    Sized("topic=" + message.topic) + Sized("type=" + message.type) +
                        Sized("md5sum=*") + Sized("message_definition="));
}

std::string Ros1BagHeader(std::uint64_t index) {
  const std::string record = Ros1Record({{"op", "\x03"},
                                         {"index_pos", Raw(index)},
                                         {"conn_count", Raw(std::uint32_t{0})},
                                         {"chunk_count", Raw(std::uint32_t{0})}},
                                        std::string(100, ' '));
  return record;
}

// ---------------------------------------------------------------------------------------- MCAP

constexpr const char* kMcapMagic = "\x89MCAP0\r\n";

std::string McapRecord(int opcode, const std::string& content) {
  return std::string(1, static_cast<char>(opcode)) +
         Raw(static_cast<std::uint64_t>(content.size())) + content;
}

std::string McapDefinitions(const std::vector<TestMessage>& messages,
                            const std::map<std::string, std::uint16_t>& numbers) {
  std::string records;
  for (const auto& [topic, number] : numbers) {
    std::string type = FirstOf(messages, topic).type;
    type.insert(type.find('/'), "/msg");
    const auto schema = static_cast<std::uint16_t>(number + 1);
    records += McapRecord(3, Raw(schema) + Sized(type) + Sized("ros2msg") + Sized(""));
    records += McapRecord(4, Raw(number) + Raw(schema) + Sized(topic) + Sized("cdr") + Sized(""));
  }
  return records;
}

std::string McapMessage(const TestMessage& message, std::uint16_t channel) {
  return McapRecord(5,
                    Raw(channel) + Raw(std::uint32_t{0}) + Raw(message.received.ns) +
                        Raw(message.received.ns) + message.bytes);
}

std::string McapChunk(const std::string& records,
                      const TestMessage& first,
                      const TestMessage& last,
                      Compression compression) {
  const auto crc = static_cast<std::uint32_t>(crc32(crc32(0, nullptr, 0),
                                                    reinterpret_cast<const Bytef*>(records.data()),
                                                    static_cast<uInt>(records.size())));
  const std::string compressed = Compressed(compression, records);
  return McapRecord(6,
                    Raw(first.received.ns) + Raw(last.received.ns) +
                        Raw(static_cast<std::uint64_t>(records.size())) + Raw(crc) +
                        Sized(CompressionName(compression, "")) +
                        Raw(static_cast<std::uint64_t>(compressed.size())) + compressed);
}

std::string McapStatistics(const std::vector<TestMessage>& messages,
                           const std::map<std::string, std::uint16_t>& numbers) {
  std::string counts;
  for (const auto& [topic, number] : numbers) {
    const auto num = std::ranges::count(messages, topic, &TestMessage::topic);
    counts += Raw(number) + Raw(static_cast<std::uint64_t>(num));
  }
  return McapRecord(11,
                    Raw(static_cast<std::uint64_t>(messages.size())) + Raw(std::uint16_t{0}) +
                        std::string(4 * 4, '\0') + Raw(messages.front().received.ns) +
                        Raw(messages.back().received.ns) + Sized(counts));
}

// ----------------------------------------------------------------------------------------- db3

void Execute(sqlite3* database, const char* sql) {
  char* message = nullptr;
  if (sqlite3_exec(database, sql, nullptr, nullptr, &message) == SQLITE_OK) return;
  const std::string text = message == nullptr ? sql : message;
  sqlite3_free(message);
  throw std::runtime_error(text);
}

class Insertion {
 public:
  Insertion(sqlite3* database, const char* sql) {
    if (sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr) != SQLITE_OK)
      throw std::runtime_error(sqlite3_errmsg(database));
  }
  Insertion(const Insertion&) = delete;
  Insertion& operator=(const Insertion&) = delete;
  ~Insertion() { sqlite3_finalize(statement_); }
  void Number(int place, std::int64_t value) { sqlite3_bind_int64(statement_, place, value); }
  void Text(int place, const std::string& text) {
    sqlite3_bind_text(statement_, place, text.c_str(), -1, SQLITE_TRANSIENT);
  }
  void Blob(int place, const std::string& bytes) {
    sqlite3_bind_blob64(statement_, place, bytes.data(), bytes.size(), SQLITE_TRANSIENT);
  }
  void Run() {
    if (sqlite3_step(statement_) != SQLITE_DONE) throw std::runtime_error("insertion failed");
    sqlite3_reset(statement_);
  }

 private:
  sqlite3_stmt* statement_ = nullptr;
};

}  // namespace

std::string Compressed(Compression compression, const std::string& bytes) {
  std::string out;
  switch (compression) {
    case Compression::kLz4:
      out.resize(LZ4F_compressFrameBound(bytes.size(), nullptr));
      out.resize(LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr));
      return out;
    case Compression::kZstd:
      out.resize(ZSTD_compressBound(bytes.size()));
      out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
      return out;
    case Compression::kBz2: {
      auto size = static_cast<unsigned>(bytes.size() + bytes.size() / 50 + 1000);
      out.resize(size);
      std::string in = bytes;
      BZ2_bzBuffToBuffCompress(
          out.data(), &size, in.data(), static_cast<unsigned>(in.size()), 9, 0, 0);
      out.resize(size);
      return out;
    }
    default:
      return bytes;
  }
}

std::string Ros1BagBytes(const std::vector<TestMessage>& messages, const TestBagOptions& options) {
  const auto numbers = NumberTopics(messages);
  std::string connections;
  for (const auto& [topic, number] : numbers)
    connections += Ros1Connection(number, FirstOf(messages, topic));
  const std::string magic = "#ROSBAG V2.0\n";
  std::string body, infos;
  const std::size_t per_chunk = std::max<std::size_t>(1, options.messages_per_chunk);
  const bool is_chunked = options.messages_per_chunk > 0;
  if (!is_chunked) body = connections;
  for (std::size_t i = 0; i < messages.size(); i += per_chunk) {
    const std::size_t end = std::min(messages.size(), i + per_chunk);
    std::string records = i == 0 && is_chunked ? connections : "";
    std::map<std::uint32_t, std::uint32_t> counts;
    for (std::size_t k = i; k < end; ++k) {
      const std::uint32_t number = numbers.at(messages[k].topic);
      ++counts[number];
      records += Ros1Record(
          {{"op", "\x02"}, {"conn", Raw(number)}, {"time", Ros1Time(messages[k].received)}},
          messages[k].bytes);
    }
    if (!is_chunked) {
      body += records;
      continue;
    }
    body += Ros1Record({{"op", "\x05"},
                        {"compression", CompressionName(options.compression, "none")},
                        {"size", Raw(static_cast<std::uint32_t>(records.size()))}},
                       Compressed(options.compression, records));
    std::string pairs;
    for (const auto& [number, count] : counts)
      pairs += Raw(number) + Raw(count);
    infos += Ros1Record({{"op", "\x06"},
                         {"ver", Raw(std::uint32_t{1})},
                         {"start_time", Ros1Time(messages[i].received)},
                         {"end_time", Ros1Time(messages[end - 1].received)}},
                        pairs);
  }
  if (!options.has_index) return magic + Ros1BagHeader(0) + body;
  const std::uint64_t index = magic.size() + Ros1BagHeader(0).size() + body.size();
  return magic + Ros1BagHeader(index) + body + connections + infos;
}

std::string McapBytes(const std::vector<TestMessage>& messages, const TestBagOptions& options) {
  const auto numbers = NumberTopics(messages);
  const std::string definitions = McapDefinitions(messages, numbers);
  std::string file = std::string(kMcapMagic, 8) + McapRecord(1, Sized("ros2") + Sized("test"));
  const std::size_t per_chunk = std::max<std::size_t>(1, options.messages_per_chunk);
  if (options.messages_per_chunk == 0) file += definitions;
  for (std::size_t i = 0; i < messages.size(); i += per_chunk) {
    const std::size_t end = std::min(messages.size(), i + per_chunk);
    std::string records = i == 0 && options.messages_per_chunk > 0 ? definitions : "";
    for (std::size_t k = i; k < end; ++k)
      records += McapMessage(messages[k], numbers.at(messages[k].topic));
    file += options.messages_per_chunk == 0
                ? records
                : McapChunk(records, messages[i], messages[end - 1], options.compression);
  }
  file += McapRecord(15, Raw(std::uint32_t{0}));
  const std::uint64_t summary = options.has_index ? file.size() : 0;
  const std::string counts = McapStatistics(messages, numbers);
  if (options.has_index)
    file += options.are_counts_first ? counts + definitions : definitions + counts;
  file += McapRecord(2, Raw(summary) + Raw(std::uint64_t{0}) + Raw(std::uint32_t{0}));
  return file + std::string(kMcapMagic, 8);
}

void WriteDb3(const std::filesystem::path& file, const std::vector<TestMessage>& messages) {
  std::filesystem::create_directories(file.parent_path());
  sqlite3* raw = nullptr;
  const int status = sqlite3_open(file.c_str(), &raw);
  const std::unique_ptr<sqlite3, decltype(&sqlite3_close)> database(raw, &sqlite3_close);
  if (status != SQLITE_OK) throw std::runtime_error("cannot create " + file.string());
  Execute(raw,
          "BEGIN; CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT "
          "NULL, serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL); CREATE "
          "TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT "
          "NULL, data BLOB NOT NULL); CREATE INDEX timestamp_idx ON messages (timestamp ASC);");
  const auto numbers = NumberTopics(messages);
  {
    Insertion topics(raw, "INSERT INTO topics VALUES(?, ?, ?, 'cdr', '')");
    for (const auto& [topic, number] : numbers) {
      std::string type = FirstOf(messages, topic).type;
      type.insert(type.find('/'), "/msg");
      topics.Number(1, number);
      topics.Text(2, topic);
      topics.Text(3, type);
      topics.Run();
    }
    Insertion rows(raw, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)");
    for (const TestMessage& message : messages) {
      rows.Number(1, numbers.at(message.topic));
      rows.Number(2, message.received.ns);
      rows.Blob(3, message.bytes);
      rows.Run();
    }
  }
  Execute(raw, "COMMIT");
}

}  // namespace facet
