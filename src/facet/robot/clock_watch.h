// SPDX-License-Identifier: BSD-2-Clause
// Notices that the clock of the sensors has gone back, as it does when a bag is played again.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace facet {
namespace robot {

/// Not thread-safe.
class ClockWatch {
 public:
  enum Stream : std::size_t { kImu, kLeft, kRight };

  /// True: the clock has gone back. One stamp that is wrong says nothing; a few of one stream in a
  /// row do.
  bool HasGoneBack(Stream stream, std::int64_t t_ns) {
    State& state = streams_[stream];
    const int needed = stream == kImu ? kImuSamples : kImages;
    // The same of the future: a single stamp there would make all that follow look late.
    if (!state.is_empty && t_ns > state.newest_ns + kBackNs && ++state.num_ahead < needed)
      return false;
    state.num_ahead = 0;
    if (state.is_empty || t_ns > state.newest_ns - kBackNs) {
      state.newest_ns = state.is_empty || t_ns > state.newest_ns ? t_ns : state.newest_ns;
      state.is_empty = false;
      state.num_back = 0;
      return false;
    }
    return ++state.num_back >= needed;
  }

  /// The clock of now is the right one.
  void Clear() { streams_ = {}; }

  std::int64_t newest_imu_ns() const { return streams_[kImu].newest_ns; }

  /// Stamps that are further back than this are not just late [ns].
  static constexpr std::int64_t kBackNs = 1'000'000'000;

 private:
  static constexpr int kImuSamples = 5, kImages = 3;

  struct State {
    bool is_empty = true;
    std::int64_t newest_ns = 0;
    int num_back = 0, num_ahead = 0;
  };
  std::array<State, 3> streams_;
};

}  // namespace robot
}  // namespace facet
