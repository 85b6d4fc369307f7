// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include "facet/camera/stereo_rig.h"

namespace facet {

/// Whether points that are seen in the left image are seen elsewhere, by more than a careful
/// calibration is wrong: in the left image itself by four pixels, or in the right one by one, far
/// away or at ten times the baseline. Of the lenses the models count, not what is beside them.
bool SeesDifferently(const StereoRig& before, const StereoRig& now);

}  // namespace facet
