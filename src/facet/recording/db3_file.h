// SPDX-License-Identifier: BSD-2-Clause
// ROS 2 bag in a SQLite database (rosbag2's storage "sqlite3").
#pragma once

#include <filesystem>
#include <map>
#include <memory>

#include "facet/recording/message_source.h"

struct sqlite3;
struct sqlite3_stmt;

namespace facet {

/// Reads row by row in the order of writing. Not thread-safe.
class Db3File : public MessageSource {
 public:
  /// Throws InputError when the file cannot be read, or is no such database. Writes
  /// nothing, neither into the file nor beside it, unless another program has it open.
  explicit Db3File(const std::filesystem::path& path);

  std::string Kind() const override { return "ROS 2 bag (sqlite3)"; }
  std::string PlaceOf(const Message& message) const override;
  const std::vector<Topic>& topics() const override { return topics_; }
  std::optional<Duration> IndexedDuration() const override { return duration_; }
  std::optional<Message> Next() override;
  void Rewind() override;

 private:
  struct CloseDatabase {
    void operator()(sqlite3* database) const;
  };
  struct FinishStatement {
    void operator()(sqlite3_stmt* statement) const;
  };
  using Statement = std::unique_ptr<sqlite3_stmt, FinishStatement>;

  [[noreturn]] void Fail(const std::string& what) const;
  Statement Prepare(const std::string& sql) const;
  bool Step(sqlite3_stmt* statement) const;
  void RequireTables() const;
  void ReadTopics();
  void ReadDuration();

  std::filesystem::path path_;
  std::unique_ptr<sqlite3, CloseDatabase> database_;
  Statement messages_;
  std::int64_t last_row_ = 0;
  bool is_ended_ = false;
  std::map<std::int64_t, std::size_t> topic_of_id_;
  std::vector<Topic> topics_;
  std::optional<Duration> duration_;
};

}  // namespace facet
