// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/view_message.h"

#include <bit>
#include <cstring>
#include <utility>

#include <zlib.h>

#include "facet/base/check.h"

namespace facet {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are written as they lie in memory");

constexpr std::size_t kHeaderBytes = 32, kBlocksAt = 10, kSizeAt = 12, kCrcAt = 28, kAlignment = 8;

template <class T>
void Append(T value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

template <class T>
void Put(T value, std::size_t at, std::string& bytes) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
}

}  // namespace

ViewMessage::ViewMessage(const Header& header) : bytes_("FCTV") {
  Append(kViewProtocol, bytes_);
  Append(static_cast<std::uint16_t>(header.type), bytes_);
  Append(static_cast<std::uint16_t>(header.source), bytes_);
  Append(std::uint16_t{0}, bytes_);  // number of blocks
  Append(std::uint32_t{0}, bytes_);  // size
  Append(header.stamp.ns, bytes_);
  Append(header.index, bytes_);
  Append(std::uint32_t{0}, bytes_);  // CRC
}

void ViewMessage::AddBlock(BlockName name,
                           ElementType type,
                           std::string_view bytes,
                           std::size_t num_numbers,
                           int per_row) {
  FACET_CHECK(per_row > 0 && num_numbers % per_row == 0)
      << num_numbers << " in rows of " << per_row;
  Append(static_cast<std::uint16_t>(name), bytes_);
  Append(static_cast<std::uint8_t>(type), bytes_);
  Append(static_cast<std::uint8_t>(per_row), bytes_);
  Append(static_cast<std::uint32_t>(num_numbers / per_row), bytes_);
  bytes_ += bytes;
  bytes_.append((kAlignment - bytes_.size() % kAlignment) % kAlignment, '\0');
  ++num_blocks_;
}

std::string ViewMessage::Finish() {
  Put(static_cast<std::uint16_t>(num_blocks_), kBlocksAt, bytes_);
  Put(static_cast<std::uint32_t>(bytes_.size()), kSizeAt, bytes_);
  const auto* blocks = reinterpret_cast<const Bytef*>(bytes_.data() + kHeaderBytes);
  const auto crc = crc32_z(0, blocks, bytes_.size() - kHeaderBytes);
  Put(static_cast<std::uint32_t>(crc), kCrcAt, bytes_);
  return std::exchange(bytes_, {});
}

}  // namespace facet
