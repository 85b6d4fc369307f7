// SPDX-License-Identifier: BSD-2-Clause
// Looks at a few pairs of a recording before it is run: are the cameras swapped, is the right one
// turned against its calibration?
#pragma once

#include <string>

#include "facet/camera/stereo_rig.h"
#include "facet/recording/recording.h"

namespace facet {

/// The rig that a run begins with.
struct AlignedRig {
  StereoRig rig;        ///< the recording's, unless there is a warning
  std::string warning;  ///< how far the right camera is turned; empty: it is not
  std::string refusal;  ///< why nothing good can come of a run; mostly empty
};

/// From four pairs of the first seconds after `start_s`. Images that cannot be used are passed
/// over. The recording is at its beginning before and after.
AlignedRig AlignStereo(Recording& recording, double start_s);

}  // namespace facet
