// SPDX-License-Identifier: BSD-2-Clause
// Noise and robust loss of every kind of factor. All of it is made from the options, and there are
// no other defaults: nobody can solve with other values than the program by leaving something out.
#pragma once

#include "facet/estimator/estimator_options.h"
#include "facet/estimator/factors/residual_scale.h"
#include "facet/geometry/angles.h"

namespace facet {

/// How well real planes obey the relations between them.
struct RelationNoise {
  double sigma_rad;          ///< parallel, orthogonal, coplanar, heading; 1-sigma
  double gravity_sigma_rad;  ///< horizontal and vertical
  double sigma_m = 0.01;     ///< offsets of coplanar planes: what a wall's parts differ by
  double huber_sigma = 2.0;  ///< relations violated by more grow linearly

  explicit RelationNoise(const RelationOptions& options)
      : sigma_rad(options.sigma_deg * kDegree),
        gravity_sigma_rad(options.gravity_sigma_deg * kDegree) {}
};

/// Landmarks of pipeline SP: noise and loss of the paper's projection factors.
struct ProjectionNoise {
  double sigma_px;
  double tukey_sigma;  ///< reprojections beyond this many sigma count as constant

  explicit ProjectionNoise(const ProjectionOptions& options)
      : sigma_px(options.sigma_px), tukey_sigma(options.tukey_sigma) {}
};

/// The sigmas of pixels and of the IMU are not here: they come with each measurement
/// (WindowObservation, ImuLink).
struct FactorNoise {
  /// Reprojections beyond this many sigma count ever less (c of GemanMcClureLoss).
  double reprojection_width;
  double plane_sigma_m;         ///< landmarks of a plane across it, each for itself, 1-sigma
  double plane_common_sigma_m;  ///< the same, what those of one plane have in common
  /// Distances to planes beyond this many of their rows' sigmas grow linearly.
  double plane_huber_sigma;
  double measurement_huber_sigma = 2.0;  ///< measurements of planes beyond this grow linearly
  RelationNoise relations;
  ProjectionNoise projection;

  explicit FactorNoise(const EstimatorOptions& options,
                       const ResidualScale& usual = ResidualScale())
      : reprojection_width(options.solver.loss_width * usual.sigma()),
        plane_sigma_m(options.solver.plane_sigma_m),
        plane_common_sigma_m(options.solver.plane_common_sigma_m),
        plane_huber_sigma(options.solver.plane_huber_sigma),
        relations(options.planes.relations),
        projection(options.projection) {}
};

}  // namespace facet
