// SPDX-License-Identifier: BSD-2-Clause
// The files of one recording, one after the other.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "facet/recording/message_source.h"

namespace facet {

/// Keeps one file open. Not thread-safe.
class SplitBag : public MessageSource {
 public:
  using Opener = std::function<std::unique_ptr<MessageSource>(const std::filesystem::path&)>;

  /// Opens each file once to collect topics and durations. CHECKs that there is a file. Throws what
  /// opening the first one throws; a later one that cannot be opened ends the recording there, as
  /// damage within a file does.
  SplitBag(std::vector<std::filesystem::path> files, Opener opener);

  std::string Kind() const override;
  std::string PlaceOf(const Message& message) const override { return source_->PlaceOf(message); }
  const std::vector<Topic>& topics() const override { return topics_; }
  std::optional<Duration> IndexedDuration() const override { return duration_; }
  std::optional<Message> Next() override;
  void Rewind() override;
  std::vector<std::string> Warnings() const override { return warnings_; }

 private:
  void Open(std::size_t file);

  std::vector<std::filesystem::path> files_;
  std::string damage_;  ///< why the file behind these cannot be opened; empty: there is none
  Opener opener_;
  std::vector<Topic> topics_;
  std::optional<Duration> duration_;
  std::vector<std::string> warnings_;
  std::unique_ptr<MessageSource> source_;
  std::size_t file_ = 0;
  std::vector<std::size_t> topic_of_source_;  ///< from the topics of the open file to ours
};

}  // namespace facet
