// SPDX-License-Identifier: BSD-2-Clause
// Gain and exposure time of every image, before any image is rendered.
#pragma once

#include <array>
#include <vector>

#include "facet/render/image_renderer.h"
#include "facet/render/simulator_options.h"

namespace facet {

struct Exposure {
  double seconds = 0;
  std::array<double, 2> gain{};  ///< grey levels per radiance, left and right
};

/// The camera's automatic exposure: follows the mean radiance of the left image with a delay, and
/// drifts a little. The cameras differ by a constant factor and a slow ripple. One entry for each
/// pose T_WC0. The result does not depend on the number of threads.
std::vector<Exposure> PlanExposures(const ImageRenderer& renderer,
                                    const CameraRays& left,
                                    const std::vector<SE3>& T_WC0,
                                    const ImageOptions& options,
                                    std::uint64_t seed,
                                    int num_threads);

}  // namespace facet
