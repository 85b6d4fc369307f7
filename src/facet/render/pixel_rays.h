// SPDX-License-Identifier: BSD-2-Clause
// Where the rays of a pixel go and how they see a texture, one for each moment of the exposure.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace facet {

struct PixelRay {
  /// Where it goes through the pixel, from its centre.
  Eigen::Vector2f offset_px = Eigen::Vector2f::Zero();
  /// How its mip level is rounded, from 0 (down) to 1 (up).
  float level_rounding = 0.5F;
};

/// `count` rays in order of time, whose offsets are normally distributed with the standard
/// deviation `blur_px`. Two that are as long before as after the middle of the exposure have
/// opposite offsets and the same rounding: otherwise the whole image would be displaced, at rest or
/// along its motion.
std::vector<PixelRay> PixelRays(int count, double blur_px);

}  // namespace facet
