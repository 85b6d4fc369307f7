// SPDX-License-Identifier: BSD-2-Clause
// When something begins that may last, and may come again.
#pragma once

#include <optional>

#include "facet/base/types.h"

namespace facet {

/// Not thread-safe.
class Episodes {
 public:
  /// What comes again within `quiet` is the same episode.
  explicit Episodes(Duration quiet) : quiet_(quiet) {}

  /// Whether an episode begins at t. Call it each time with whether it holds, in order of time.
  bool Begins(Timestamp t, bool holds) {
    if (!holds) return false;
    const bool begins = !last_ || t - *last_ > quiet_;
    last_ = t;
    return begins;
  }

 private:
  Duration quiet_;
  std::optional<Timestamp> last_;  // when it held
};

}  // namespace facet
