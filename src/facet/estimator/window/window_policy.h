// SPDX-License-Identifier: BSD-2-Clause
// Decides what leaves the window: the oldest motions, and of the older keyframes the most
// redundant.
#pragma once

#include "facet/estimator/estimator_options.h"
#include "facet/estimator/window/marginalization_plan.h"

namespace facet {

/// Plan for a window whose newest frame is a keyframe.
MarginalizationPlan PlanMarginalization(const SlidingWindow& window, const WindowOptions& options);

/// The frame whose removal loses least, among frames [first, last]; both inclusive.
int MostRedundantFrame(const SlidingWindow& window, int first, int last, double covisible_share);

/// Whether the frame could go without a trace: another frame stands at almost the same place
/// (measured in parallax of the landmarks) and sees almost the same landmarks. So it is at rest.
bool IsDuplicate(const SlidingWindow& window, int frame);

}  // namespace facet
