// SPDX-License-Identifier: BSD-2-Clause
// Brushes that textures are painted with. A canvas is a float image of albedo, 0 black to 1 white;
// values outside are allowed on the way and clipped at the end.
#pragma once

#include <opencv2/core.hpp>

#include "facet/base/random.h"

namespace facet {

using GreyCanvas = cv::Mat1f;

struct NoiseOptions {
  int size_px = 1024;      ///< side of the square result, a power of two
  int min_period = 4;      ///< waves per side of the coarsest octave
  double stretch = 1;      ///< > 1: features are this much longer in x than in y (a power of two)
  double persistence = 1;  ///< amplitude of an octave relative to the one before; 1: the 1/f
                           ///< amplitude spectrum of natural images, less: smoother
};

/// Smooth noise in octaves, mean 0, standard deviation 1, without seams when tiled.
GreyCanvas FractalNoise(const NoiseOptions& options, Rng& rng);

/// Shapes that cover each other, with sizes after a power law: the edges and the statistics of
/// photographs (Lee, Mumford and Huang, IJCV 2001). Albedo 0.15 to 0.7.
GreyCanvas DeadLeaves(int size_px, Rng& rng);

/// Lines of letters and figures, dark on white.
GreyCanvas PrintedSheet(int size_px, Rng& rng);

/// Short dark or bright lines of random direction.
void Scratch(GreyCanvas& canvas, int count, double strength, Rng& rng);

/// Small round spots, radius up to max_radius_px, that darken or brighten by up to `strength`.
void Speckle(GreyCanvas& canvas, int count, double max_radius_px, double strength, Rng& rng);

}  // namespace facet
