// SPDX-License-Identifier: BSD-2-Clause
// The same simulated measurements in a world of another size.
#pragma once

#include "bench/consistency_scenario.h"

namespace facet {

/// The run as it would be if all lengths were `scale` times as long: flight, scene and stereo pair.
/// The images are the same to the last bit. The IMU turns as before and accelerates, errs and
/// drifts `scale` times as much, in a gravity that is `scale` times as strong: nothing but fixed
/// lengths, speeds and accelerations in the code can tell the two worlds apart.
SimulatedRun ScaledRun(SimulatedRun run, double scale);

/// The noise of that run's IMU, its gravity, and what the estimator expects of lengths, speeds and
/// accelerations before it has seen anything.
ConsistencyOptions ScaledOptions(ConsistencyOptions options, double scale);

}  // namespace facet
