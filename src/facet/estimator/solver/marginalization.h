// SPDX-License-Identifier: BSD-2-Clause
// Turns what leaves the window into a quadratic prior on what stays (docs/math.md, section 5).
#pragma once

#include "facet/camera/stereo_rig.h"
#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/window/marginalization_plan.h"

namespace facet {

/// Carries out the plan. Every factor that touches a leaving variable is used once, here, and
/// removed: the IMU links of leaving motions, all observations of leaving landmarks, the relations
/// of leaving planes, what leaving frames have measured, the old prior. A landmark that stays but
/// was seen in a leaving frame loses that one observation. Variables that the new prior touches are
/// frozen at the present estimate, unless they already are.
void Marginalize(const MarginalizationPlan& plan,
                 const StereoRig& rig,
                 const FactorNoise& noise,
                 SlidingWindow& window);

}  // namespace facet
