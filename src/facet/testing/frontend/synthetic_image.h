// SPDX-License-Identifier: BSD-2-Clause
// A texture that is known everywhere, for tests: sums of waves, rendered through any map.
#pragma once

#include <cmath>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/base/random.h"

namespace facet::testing {

/// Band-limited random texture with grey values around 125.
class WaveTexture {
 public:
  explicit WaveTexture(std::uint64_t seed, double max_frequency = 0.7) {
    Rng rng(seed);
    for (int k = 0; k < kNumWaves; ++k) {
      const double f = rng.Uniform(0.05, max_frequency), a = rng.Uniform(0, 6.2831853);
      waves_.push_back({f * std::cos(a), f * std::sin(a), rng.Uniform(0, 6.2831853)});
    }
  }

  double operator()(double x, double y) const {
    double sum = 0;
    for (const Wave& w : waves_)
      sum += std::sin(w.fx * x + w.fy * y + w.phase);
    return 125 + kAmplitude * sum;
  }

 private:
  static constexpr int kNumWaves = 30;
  static constexpr double kAmplitude = 7.5;
  struct Wave {
    double fx, fy, phase;
  };
  std::vector<Wave> waves_;
};

/// pixel(x, y) = gain * texture(map(x, y)) + offset, with noise of the given sigma.
template <class Texture, class Map>
cv::Mat Render(const Texture& texture,
               int width,
               int height,
               const Map& map,
               double gain = 1,
               double offset = 0,
               double noise = 0) {
  cv::Mat image(height, width, CV_8UC1);
  Rng rng(99);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto p = map(static_cast<double>(x), static_cast<double>(y));
      double value = gain * texture(p.x(), p.y()) + offset;
      if (noise > 0) value += noise * rng.Normal();
      image.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(value);
    }
  }
  return image;
}

}  // namespace facet::testing
