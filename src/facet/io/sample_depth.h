// SPDX-License-Identifier: BSD-2-Clause
// Grey values of 10, 12 and 16 bits in 16-bit samples.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

namespace facet {

/// What `max`, the largest value of a few images, says about the bits that are used: 10 or 12 where
/// the upper ones are never set (cameras write such images right-aligned), otherwise 16.
inline int UsedSampleBits(std::uint16_t max) {
  if (max < (1 << 10)) return 10;
  return max < (1 << 12) ? 12 : 16;
}

inline std::string SampleBitsWarning(int bits, std::uint16_t max) {
  return "images have 16-bit samples of which " + std::to_string(bits) +
         " bits are used (the largest value is " + std::to_string(max) +
         "); they are scaled from those";
}

/// Scales a value of `bits` bits to 8; larger ones become 255. For 16 bits exactly as libpng does.
inline std::uint8_t ToEightBits(std::uint32_t value, int bits) {
  if (bits == 16) return static_cast<std::uint8_t>((value * 255 + 32895) >> 16);
  const std::uint32_t max = (1U << bits) - 1;
  return static_cast<std::uint8_t>((std::min(value, max) * 255 + max / 2) / max);
}

}  // namespace facet
