// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/pixel_rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace facet {
namespace {

/// Element i of the van der Corput sequence: well spread in [0, 1) for any count.
double RadicalInverse(int i, int base) {
  double result = 0, digit = 1.0 / base;
  for (; i > 0; i /= base, digit /= base)
    result += digit * (i % base);
  return result;
}

/// Well spread over a normal distribution that is cut off at two and a half sigma.
Eigen::Vector2f LensOffset(int i, double blur_px) {
  const double r = std::min(2.5, std::sqrt(-2 * std::log(1 - RadicalInverse(i + 1, 2))));
  const double angle = std::numbers::pi * RadicalInverse(i + 1, 3);
  return Eigen::Vector2d(blur_px * r * std::cos(angle), blur_px * r * std::sin(angle))
      .cast<float>();
}

}  // namespace

std::vector<PixelRay> PixelRays(int count, double blur_px) {
  std::vector<PixelRay> rays(static_cast<std::size_t>(count));
  const int num_pairs = count / 2;
  // Neighbours in time get distant offsets: 7 is coprime to every number that is no multiple of it.
  const int stride = num_pairs % 7 == 0 ? 5 : 7;
  for (int i = 0; i < num_pairs; ++i) {
    const int pair = i * stride % num_pairs;
    PixelRay& before = rays[static_cast<std::size_t>(i)];
    PixelRay& after = rays[static_cast<std::size_t>(count - 1 - i)];
    before.offset_px = LensOffset(pair, blur_px);
    after.offset_px = -before.offset_px;
    before.level_rounding = after.level_rounding =
        (static_cast<float>(pair) + 0.5F) / static_cast<float>(num_pairs);
  }
  return rays;
}

}  // namespace facet
