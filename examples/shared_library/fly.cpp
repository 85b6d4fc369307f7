// SPDX-License-Identifier: BSD-2-Clause
#include <cmath>
#include <cstdio>

#include "tracker.h"

int main() {
  const TrackedPosition p = TrackAtRest();
  std::printf("at %.4f %.4f %.4f m, %d poses observed\n", p.x, p.y, p.z, p.num_calls);
  const bool is_at_rest = std::hypot(p.x, p.y, p.z) < 0.01;
  return p.is_known && is_at_rest && p.num_calls > 20 ? 0 : 1;
}
