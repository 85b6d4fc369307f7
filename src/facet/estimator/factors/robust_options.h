// SPDX-License-Identifier: BSD-2-Clause
// How much the rows of landmarks and planes weigh.
#pragma once

namespace facet {

/// How well real planes obey the relations between them.
struct RelationNoise {
  double sigma_rad = 0.0122;          ///< parallel, orthogonal, coplanar, heading; 1-sigma
  double gravity_sigma_rad = 0.0122;  ///< horizontal and vertical
  double sigma_m = 0.01;              ///< offsets of coplanar planes
  double huber_sigma = 2.0;           ///< relations violated by more grow linearly
};

/// Landmarks of pipeline SP: noise and loss of the paper's projection factors.
struct ProjectionNoise {
  double sigma_px = 1.8;
  double tukey_sigma = 4.685;  ///< reprojections beyond this many sigma count as constant
};

struct RobustOptions {
  /// Reprojections beyond this many sigma count ever less (c of GemanMcClureLoss).
  double reprojection_width = 5.0;
  double plane_sigma_m = 0.02;  ///< landmarks of a plane across it, each for itself, 1-sigma
  double plane_common_sigma_m = 0.0025;  ///< the same, what those of one plane have in common
  double plane_huber_sigma = 2.0;  ///< distances to planes beyond this many of their rows' sigmas
                                   ///< grow linearly
  double sighting_huber_sigma = 2.0;  ///< sightings of planes beyond this grow linearly
  RelationNoise relations{};
  ProjectionNoise projection{};
};

}  // namespace facet
