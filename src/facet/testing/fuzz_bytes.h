// SPDX-License-Identifier: BSD-2-Clause
// For fuzzing: turns bytes that somebody else chose into the numbers that a test feeds to the code
// under test. Few bytes choose between usual values and absurd ones, so that both are found soon.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace facet::testing {

/// Hands out the bytes one after the other; behind the end there are zeros.
class FuzzBytes {
 public:
  explicit FuzzBytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool empty() const { return next_ >= bytes_.size(); }

  std::uint8_t Byte() { return empty() ? std::uint8_t{0} : bytes_[next_++]; }

  /// From 0 to n - 1; n <= 256.
  int Index(int n) { return Byte() % n; }
  bool Flag() { return (Byte() & 1) != 0; }

  /// From -scale to scale.
  double Near(double scale) { return scale * (Byte() - 127.5) / 127.5; }

  std::int64_t Integer() {
    std::uint64_t bits = 0;
    for (int i = 0; i < 8; ++i)
      bits = bits << 8 | Byte();
    return static_cast<std::int64_t>(bits);
  }

  /// Any number there is, and what is none.
  double Real() {
    using Limits = std::numeric_limits<double>;
    constexpr double kSpecial[] = {0,
                                   -0.0,
                                   1,
                                   -1,
                                   Limits::infinity(),
                                   -Limits::infinity(),
                                   Limits::quiet_NaN(),
                                   Limits::max(),
                                   -Limits::max(),
                                   Limits::denorm_min(),
                                   Limits::epsilon(),
                                   1e-200,
                                   1e150,
                                   1e20,
                                   -1e9,
                                   1e5};
    constexpr int kNumSpecial = sizeof(kSpecial) / sizeof(kSpecial[0]);
    const int choice = Index(2 * kNumSpecial);
    return choice < kNumSpecial ? kSpecial[choice] : std::bit_cast<double>(Integer());
  }

  /// The end of time, or anywhere in it.
  std::int64_t AnyStamp() {
    using Limits = std::numeric_limits<std::int64_t>;
    switch (Index(6)) {
      case 0:
        return Limits::min();
      case 1:
        return Limits::max();
      case 2:
        return 0;
      case 3:
        return -1;
      default:
        return Integer();
    }
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t next_ = 0;
};

}  // namespace facet::testing
