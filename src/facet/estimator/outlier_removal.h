// SPDX-License-Identifier: BSD-2-Clause
// Observations that do not fit the window after its solve are taken out of it.
#pragma once

#include "facet/estimator/vision_factor.h"

namespace facet {

/// Removes observations that are off by more than `max_sigma`, with what the robust loss and the
/// noise of projections say; a landmark without any, and one nearer than a few centimetres, goes as
/// a whole. A landmark that loses its host's observation gets another host. Landmarks that do not
/// constrain the window are left alone. Returns the number of observations removed one by one.
/// `geometry` must be up to date.
int RemoveOutlierObservations(const FrameGeometry& geometry,
                              const RobustOptions& robust,
                              double max_sigma,
                              SlidingWindow& window);

}  // namespace facet
