// SPDX-License-Identifier: BSD-2-Clause
// What the program has used so far.
#pragma once

namespace facet {

/// Processor time of all threads [s].
double ProcessCpuSeconds();

/// Largest memory so far [MB].
double PeakRssMb();

}  // namespace facet
