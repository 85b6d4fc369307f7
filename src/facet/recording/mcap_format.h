// SPDX-License-Identifier: BSD-2-Clause
// What reader and writer of MCAP files share (https://mcap.dev/spec).
#pragma once

#include <array>
#include <cstdint>

namespace facet::mcap {

/// At the beginning and the end of a file.
inline constexpr std::array<std::uint8_t, 8> kMagic = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
inline constexpr std::uint64_t kRecordHeader = 9;  ///< bytes: opcode and length

enum Opcode : std::uint8_t {
  kOpHeader = 0x01,
  kOpFooter = 0x02,
  kOpSchema = 0x03,
  kOpChannel = 0x04,
  kOpMessage = 0x05,
  kOpChunk = 0x06,
  kOpMessageIndex = 0x07,
  kOpChunkIndex = 0x08,
  kOpStatistics = 0x0B,
  kOpDataEnd = 0x0F,
};

}  // namespace facet::mcap
