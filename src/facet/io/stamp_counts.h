// SPDX-License-Identifier: BSD-2-Clause
// What readers leave out because of its stamp.
#pragma once

namespace facet {

struct StampCounts {
  int num_backward = 0;  ///< before the newest one
  int num_repeated = 0;  ///< equal to it

  StampCounts& operator+=(const StampCounts& other) {
    num_backward += other.num_backward;
    num_repeated += other.num_repeated;
    return *this;
  }
};

}  // namespace facet
