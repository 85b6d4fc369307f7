// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/decompressed_messages.h"

#include <algorithm>
#include <array>

#include "facet/io/errors.h"
#include "facet/recording/decompression.h"

namespace facet {
namespace {

/// CDR begins with a zero.
bool IsZstd(std::span<const std::uint8_t> bytes) {
  constexpr std::array<std::uint8_t, 4> kMagic = {0x28, 0xB5, 0x2F, 0xFD};
  return bytes.size() > kMagic.size() && std::equal(kMagic.begin(), kMagic.end(), bytes.begin());
}

}  // namespace

std::optional<Message> DecompressedMessages::Next() {
  auto message = source_->Next();
  if (!message || topics()[message->topic].encoding != MessageEncoding::kCdr) return message;
  if (!IsZstd(message->bytes)) return message;
  try {
    message->bytes = DecompressZstdFrame(message->bytes, buffer_);
  } catch (const InputError&) {
    message->bytes = {};
  }
  return message;
}

}  // namespace facet
