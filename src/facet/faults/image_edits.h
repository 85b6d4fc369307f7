// SPDX-License-Identifier: BSD-2-Clause
// Changes of single images.
#pragma once

#include "facet/camera/stereo_rig.h"
#include "facet/faults/recording_copy.h"

namespace facet {

/// Every pixel gets this value.
ImageEdit Filled(int grey);

/// Every pixel times `gain`, clipped.
ImageEdit Brightened(double gain);

/// Dirt or a hand over the lower part of the lens: `share` of the rows, without texture.
ImageEdit Covered(double share);

/// White noise of this standard deviation [grey values]; differs with the seed.
ImageEdit Noisy(double sigma, std::uint64_t seed);

/// Darker by one factor, so that the mean is `mean`; a darker image stays as it is.
ImageEdit DarkenedTo(double mean);

/// Brighter by one factor, so that this share of the pixels is clipped.
ImageEdit ClippedAtTop(double share);

/// As an image out of focus [px].
ImageEdit Blurred(double sigma_px);

/// Differences from the mean times `contrast`.
ImageEdit Faded(double contrast);

/// Bright dots at places that depend on the seed alone.
ImageEdit Dotted(double grey, int num_dots, std::uint64_t seed);

/// A board with a texture of its own that moves to and fro in front of the cameras at a depth of
/// `depth_m`, upright to the left camera's axis, and covers `share` of the left image. Distortion
/// is left out. `phase`: 0 at the left border, 1 at the right one.
ImageEdit WithBoard(
    const StereoRig& rig, std::size_t camera, double share, double depth_m, double phase);

/// What the camera sees once it is turned by `R` (from its new axes to its old ones) where it
/// stands; repeats the border where it did not see before.
ImageEdit Turned(const CameraModel& camera, const Matrix3d& R);

}  // namespace facet
