// SPDX-License-Identifier: BSD-2-Clause
// The compressions of chunks in bags.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace facet {

enum class Compression { kNone, kLz4, kBz2, kZstd };

/// From the names that bags use: "", "none", "lz4", "bz2", "zstd"; empty for another one.
std::optional<Compression> CompressionFromText(std::string_view name);

/// Decompresses into `buffer`, which only grows, and grows as data really come out: a size that is
/// announced and not there costs no memory. Throws InputError, without a place, for damaged data,
/// where there are not exactly `size` bytes, and for more than 1 GB: a few compressed bytes may
/// stand for any number. The result is `data` itself for kNone.
std::span<const std::uint8_t> Decompress(Compression compression,
                                         std::span<const std::uint8_t> data,
                                         std::uint64_t size,
                                         std::vector<std::uint8_t>& buffer);

/// The same for zstd data that say themselves how many bytes they stand for; throws InputError,
/// too, where they do not.
std::span<const std::uint8_t> DecompressZstdFrame(std::span<const std::uint8_t> data,
                                                  std::vector<std::uint8_t>& buffer);

}  // namespace facet
