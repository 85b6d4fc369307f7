// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/exposure.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "facet/render/parallel_for.h"

namespace facet {

std::vector<Exposure> PlanExposures(const ImageRenderer& renderer,
                                    const CameraRays& left,
                                    const std::vector<SE3>& T_WC0,
                                    const ImageOptions& options,
                                    std::uint64_t seed,
                                    int num_threads) {
  constexpr int kStepPx = 16;
  constexpr double kDelay_s = 0.3;
  constexpr double kMinRadiance = 1e-3;
  std::vector<double> radiance(T_WC0.size());
  ParallelFor(static_cast<int>(T_WC0.size()), num_threads, [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    radiance[k] = std::max(kMinRadiance, renderer.MeanRadiance(left, T_WC0[k], kStepPx));
  });
  Rng rng(seed);
  const double right_share = options.right_gain * rng.Uniform(-1, 1);
  const double ripple_hz = rng.Uniform(0.05, 0.2), phase = rng.Uniform(0, 6);
  const double overall = std::accumulate(radiance.begin(), radiance.end(), 0.0) /
                         static_cast<double>(std::max<std::size_t>(1, radiance.size()));

  std::vector<Exposure> exposures;
  double followed = radiance.empty() ? 1 : radiance.front();
  double drift = 0;
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    const double dt = 1 / options.rate_hz;
    followed += std::min(1.0, dt / kDelay_s) * (radiance[i] - followed);
    drift += -dt / 5 * drift + 0.03 * std::sqrt(dt) * rng.Normal();
    const double mean = options.auto_exposure ? followed * std::exp(-drift) : overall;
    const double gain = options.mean_level / mean;
    Exposure exposure;
    // Half of the brightness range by time, the rest by amplification.
    const double darkness = std::sqrt(overall / mean);
    exposure.seconds =
        options.motion_blur ? options.max_exposure_s * std::min(1.0, 0.7 * darkness) : 0;
    const double t = static_cast<double>(i) * dt;
    const double ripple =
        options.right_gain > 0 ? 0.01 * std::sin(2 * std::numbers::pi * ripple_hz * t + phase) : 0;
    exposure.gain = {gain, gain * (1 + right_share + ripple)};
    exposures.push_back(exposure);
  }
  return exposures;
}

}  // namespace facet
