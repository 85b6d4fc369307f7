// SPDX-License-Identifier: BSD-2-Clause
// The same simulated measurements in a world of another size.
#pragma once

#include "bench/consistency_scenario.h"

namespace facet {

/// The run as it would be if all lengths were `scale` times as long: flight, scene and stereo pair.
/// The images are the same to the last bit. The IMU turns as before and accelerates, errs and
/// drifts `scale` times as much in the same gravity. `trajectory`: that the run was simulated
/// along.
SimulatedRun ScaledRun(SimulatedRun run, const SplineTrajectory& trajectory, double scale);

/// The noise of that run's IMU.
ConsistencyOptions ScaledOptions(ConsistencyOptions options, double scale);

}  // namespace facet
