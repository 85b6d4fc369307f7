// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/db3_file.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <system_error>

#include <sqlite3.h>

#include "facet/io/errors.h"

namespace facet {
namespace {

std::string ColumnText(sqlite3_stmt* statement, int column) {
  const unsigned char* text = sqlite3_column_text(statement, column);
  const int size = sqlite3_column_bytes(statement, column);
  if (text == nullptr) return {};
  return {reinterpret_cast<const char*>(text), static_cast<std::size_t>(size)};
}

/// A database with a write-ahead log, as rosbag2 writes it, cannot be opened in a folder that
/// cannot be written, unless it is declared to be immutable; that is wrong only while there is a
/// log.
std::string UriOf(const std::filesystem::path& path) {
  std::string uri = path.is_absolute() ? "file://" : "file:";
  for (const char c : path.string()) {
    if (c == '?' || c == '#' || c == '%') {
      char text[8];
      std::snprintf(text, sizeof(text), "%%%02X", static_cast<unsigned>(c));
      uri += text;
    } else {
      uri += c;
    }
  }
  std::error_code error;
  const bool has_log = std::filesystem::exists(path.string() + "-wal", error) ||
                       std::filesystem::exists(path.string() + "-journal", error);
  return has_log ? uri : uri + "?immutable=1";
}

}  // namespace

void Db3File::CloseDatabase::operator()(sqlite3* database) const {
  sqlite3_close(database);
}

void Db3File::FinishStatement::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

Db3File::Db3File(const std::filesystem::path& path) : path_(path) {
  sqlite3* raw = nullptr;
  const int status = sqlite3_open_v2(UriOf(path).c_str(),
                                     &raw,
                                     SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_URI,
                                     nullptr);
  database_.reset(raw);
  if (status != SQLITE_OK) Fail("cannot be opened");
  // A damaged file must not make the library allocate more than the file can hold, or run code.
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  constexpr std::uintmax_t kMost = std::numeric_limits<int>::max() / 2, kLeast = 1 << 16;
  sqlite3_limit(raw, SQLITE_LIMIT_LENGTH, static_cast<int>(std::clamp(size, kLeast, kMost)));
  sqlite3_db_config(raw, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  RequireTables();
  ReadTopics();
  ReadDuration();
  Rewind();
}

void Db3File::Fail(const std::string& what) const {
  const std::string at = last_row_ > 0 ? ": behind message " + std::to_string(last_row_) : "";
  throw InputError(
      path_.string() + at + ": " + what + " (SQLite: " + sqlite3_errmsg(database_.get()) +
      "); copy the file again, repair it with `sqlite3 FILE .recover`, or use the part "
      "before with --duration");
}

Db3File::Statement Db3File::Prepare(const std::string& sql) const {
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(database_.get(), sql.c_str(), -1, &raw, nullptr) != SQLITE_OK) {
    Fail("this is no bag of ROS 2, or it is damaged");
  }
  return Statement(raw);
}

std::string Db3File::PlaceOf(const Message& message) const {
  return path_.string() + ": message " + std::to_string(message.offset);
}

/// False behind the last row.
bool Db3File::Step(sqlite3_stmt* statement) const {
  const int status = sqlite3_step(statement);
  if (status != SQLITE_ROW && status != SQLITE_DONE) Fail("the database is damaged");
  return status == SQLITE_ROW;
}

/// Views could be anything, endless ones too.
void Db3File::RequireTables() const {
  const Statement statement = Prepare(
      "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages') "
      "AND sql NOT LIKE '%VIRTUAL%'");
  if (!Step(statement.get()) || sqlite3_column_int(statement.get(), 0) != 2) {
    Fail("a database without the tables 'topics' and 'messages' is no bag of ROS 2");
  }
}

void Db3File::ReadTopics() {
  const Statement statement =
      Prepare("SELECT id, name, type, serialization_format FROM topics ORDER BY rowid");
  while (Step(statement.get())) {
    Topic topic;
    topic.name = ColumnText(statement.get(), 1);
    topic.type = Ros1TypeName(ColumnText(statement.get(), 2));
    topic.encoding = EncodingFromText(ColumnText(statement.get(), 3));
    try {
      topic_of_id_[sqlite3_column_int64(statement.get(), 0)] = FindOrAddTopic(topics_, topic);
    } catch (const InputError& error) {
      Fail(error.what());
    }
  }
}

/// Of the first and last row; counting the messages of each topic would read the whole file.
void Db3File::ReadDuration() {
  const Statement first = Prepare("SELECT timestamp FROM messages ORDER BY rowid LIMIT 1");
  const Statement last = Prepare("SELECT timestamp FROM messages ORDER BY rowid DESC LIMIT 1");
  if (!Step(first.get()) || !Step(last.get())) {
    topics_.clear();
    return;
  }
  duration_ = Timestamp{sqlite3_column_int64(last.get(), 0)} -
              Timestamp{sqlite3_column_int64(first.get(), 0)};
}

void Db3File::Rewind() {
  last_row_ = 0;
  is_ended_ = false;
  messages_ = Prepare("SELECT rowid, topic_id, timestamp, data FROM messages ORDER BY rowid");
}

std::optional<Message> Db3File::Next() {
  while (!is_ended_ && Step(messages_.get())) {
    last_row_ = sqlite3_column_int64(messages_.get(), 0);
    const auto topic = topic_of_id_.find(sqlite3_column_int64(messages_.get(), 1));
    if (topic == topic_of_id_.end()) continue;
    Message message;
    message.topic = topic->second;
    message.received.ns = sqlite3_column_int64(messages_.get(), 2);
    const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(messages_.get(), 3));
    const int size = sqlite3_column_bytes(messages_.get(), 3);
    if (data != nullptr && size > 0) message.bytes = {data, static_cast<std::size_t>(size)};
    message.offset = static_cast<std::uint64_t>(last_row_);
    return message;
  }
  is_ended_ = true;  // SQLite would begin again
  return std::nullopt;
}

}  // namespace facet
