// SPDX-License-Identifier: BSD-2-Clause
// Numbers, strings and blocks of bytes one after the other, never beyond the end.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "facet/io/errors.h"

namespace facet {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie");

/// Of little-endian data. Throws InputError, without a place, where the data end too early.
class ByteReader {
 public:
  using Bytes = std::span<const std::uint8_t>;
  explicit ByteReader(Bytes bytes) : bytes_(bytes) {}

  std::size_t position() const { return position_; }
  std::size_t remaining() const { return bytes_.size() - position_; }

  Bytes Block(std::uint64_t size) {
    if (size > remaining()) {
      throw InputError("ends after " + std::to_string(bytes_.size()) + " bytes, " +
                       std::to_string(size - remaining()) + " more are announced");
    }
    const Bytes block = bytes_.subspan(position_, size);
    position_ += size;
    return block;
  }

  template <class T>
  T Number() {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    std::memcpy(&value, Block(sizeof(T)).data(), sizeof(T));
    return value;
  }

  /// `size` bytes as text; it lies in the data.
  std::string_view Text(std::uint64_t size) {
    const Bytes block = Block(size);
    return {reinterpret_cast<const char*>(block.data()), block.size()};
  }

 private:
  Bytes bytes_;
  std::size_t position_ = 0;
};

}  // namespace facet
