// SPDX-License-Identifier: BSD-2-Clause
#include "facet/base/stage_timer.h"

#include <ctime>

namespace facet {

double ThreadCpuMs() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

}  // namespace facet
