// SPDX-License-Identifier: BSD-2-Clause
// Decides what leaves the window: the oldest motions, and of the older keyframes the most redundant.
#pragma once

#include "facet/estimator/estimator_options.h"
#include "facet/estimator/marginalization.h"

namespace facet {

/// Plan for a window whose newest frame is a keyframe (or, with keep_every_frame, any frame).
MarginalizationPlan PlanMarginalization(const SlidingWindow& window, const WindowOptions& options);

/// The frame whose removal loses least, among frames [first, last]; both inclusive.
int MostRedundantFrame(const SlidingWindow& window, int first, int last, double covisible_share);

}  // namespace facet
