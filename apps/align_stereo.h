// SPDX-License-Identifier: BSD-2-Clause
// Looks at a few pairs of a recording before it is run: is the right camera turned against its
// calibration?
#pragma once

#include <string>

#include "facet/camera/stereo_rig.h"
#include "facet/io/asl_dataset.h"

namespace facet {

/// The rig that a run begins with.
struct AlignedRig {
  StereoRig rig;        ///< the dataset's, unless there is a warning
  std::string warning;  ///< how far the right camera is turned; empty: it is not
};

/// From four pairs of the first seconds after `start_s`. Images that cannot be used are passed
/// over.
AlignedRig AlignStereo(AslDataset& dataset, double start_s);

}  // namespace facet
