// SPDX-License-Identifier: BSD-2-Clause
// A file that is read in pieces. Every message about it names the file and the offset.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace facet {

using ByteSpan = std::span<const std::uint8_t>;

/// Not thread-safe.
class RandomAccessFile {
 public:
  /// Throws InputError when the file cannot be opened, is no regular file or is empty.
  explicit RandomAccessFile(const std::filesystem::path& path);
  RandomAccessFile(const RandomAccessFile&) = delete;
  RandomAccessFile& operator=(const RandomAccessFile&) = delete;
  ~RandomAccessFile();

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }

  /// Reads into `buffer`, which only grows. Throws InputError where the file ends before: nothing
  /// is allocated that the file does not hold.
  ByteSpan Read(std::uint64_t offset, std::uint64_t size, std::vector<std::uint8_t>& buffer) const;

  /// "a.bag: at byte 17".
  std::string PlaceOf(std::uint64_t offset) const;

  /// Throws InputError with file, offset and text.
  [[noreturn]] void Fail(std::uint64_t offset, const std::string& text) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace facet
