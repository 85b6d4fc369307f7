// SPDX-License-Identifier: BSD-2-Clause
// For tests: small bags, written after the descriptions of their formats.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "facet/recording/decompression.h"
#include "facet/testing/recording/test_messages.h"

namespace facet {

struct TestBagOptions {
  Compression compression = Compression::kNone;
  std::size_t messages_per_chunk = 20;  ///< 0: no chunks
  bool has_index = true;                ///< of MCAP: the summary
  bool are_counts_first = false;        ///< of MCAP: in the summary, before the channels
};

std::string Ros1BagBytes(const std::vector<TestMessage>& messages,
                         const TestBagOptions& options = {});
std::string McapBytes(const std::vector<TestMessage>& messages, const TestBagOptions& options = {});

/// A database of rosbag2; throws std::runtime_error when SQLite refuses.
void WriteDb3(const std::filesystem::path& file, const std::vector<TestMessage>& messages);

/// One block of compressed data.
std::string Compressed(Compression compression, const std::string& bytes);

}  // namespace facet
