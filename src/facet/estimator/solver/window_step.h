// SPDX-License-Identifier: BSD-2-Clause
// Moves the window by a solution: the third of the three parts of a solve (linearise, reduce,
// step).
#pragma once

#include "facet/estimator/solver/linearized_window.h"

namespace facet {

/// Moves frames and planes by `step`, and the landmarks, whose blocks a ReducedSystem has
/// eliminated, by what follows from it.
void ApplyStep(const LinearizedWindow& linear, const VectorXd& step, SlidingWindow& window);

}  // namespace facet
