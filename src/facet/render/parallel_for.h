// SPDX-License-Identifier: BSD-2-Clause
// The simulator's only threads.
#pragma once

#include <functional>

namespace facet {

/// Calls work(0) .. work(count - 1), each once, on `num_threads` threads, in an order that is not
/// defined: calls must not depend on each other. Afterwards rethrows the first exception that a
/// call threw; no further call begins after one.
void ParallelFor(int count, int num_threads, const std::function<void(int)>& work);

}  // namespace facet
