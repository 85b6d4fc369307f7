// SPDX-License-Identifier: BSD-2-Clause
// Published messages in an MCAP file, which Foxglove opens.
#pragma once

#include <array>
#include <filesystem>

#include "facet/publish/publisher.h"
#include "facet/recording/mcap_writer.h"

namespace facet {

/// Not thread-safe. The file has its name when it is complete, as McapWriter's; before, and where
/// the disk is full, at most a second of the run is missing in FILE.partial.
class McapRecorder {
 public:
  /// Throws OutputError, as all functions do, when the file cannot be written.
  explicit McapRecorder(const std::filesystem::path& file);

  void Add(const PublishedMessage& message);
  void Commit() { writer_.Commit(); }

 private:
  McapWriter writer_;
  Timestamp chunk_end_;  ///< a second after the first message of the chunk
  std::array<std::uint16_t, kChannels.size()> channels_{};
};

}  // namespace facet
