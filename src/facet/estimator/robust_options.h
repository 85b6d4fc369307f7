// SPDX-License-Identifier: BSD-2-Clause
// How much the rows of a landmark weigh.
#pragma once

namespace facet {

struct RobustOptions {
  double huber_sigma = 2.0;        ///< reprojections beyond this many sigma grow linearly
  double plane_sigma_m = 0.01;     ///< how flat real planes are, 1-sigma
  double plane_huber_sigma = 2.0;  ///< distances to planes beyond this many sigma grow linearly
};

}  // namespace facet
