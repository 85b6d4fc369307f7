// SPDX-License-Identifier: BSD-2-Clause
// The EuRoC vehicle's cameras (Burri et al., IJRR 2016; cam0 and cam1 of the sensor.yaml files), so
// that simulations need no calibration file.
#pragma once

#include "facet/camera/stereo_rig.h"

namespace facet {

StereoRig EurocRig();

}  // namespace facet
