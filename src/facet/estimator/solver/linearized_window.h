// SPDX-License-Identifier: BSD-2-Clause
// Assembles all factors of a window into normal equations: the first of the three parts of a solve
// (linearise, reduce, step).
#pragma once

#include <vector>

#include "facet/estimator/factors/landmark_factors.h"
#include "facet/estimator/factors/normal_equations.h"
#include "facet/estimator/solver/vision_system.h"
#include "facet/estimator/window/frame_geometry.h"

namespace facet {

/// All factors at one estimate, to first order. Reuse one object: it keeps its storage. Not
/// thread-safe.
struct LinearizedWindow {
  /// Everything but the landmarks' own columns.
  NormalEquations equations;
  /// The constraining landmarks, in the order of the window: the first num_landmarks.
  std::vector<LandmarkBlock> landmarks;
  int num_landmarks = 0;
  std::vector<LandmarkBlock::View> views;               ///< all of theirs
  std::vector<LandmarkBlock::PoseSquare> pose_squares;  ///< the buffer that is lent to them
  /// What the landmarks add to frames, planes, lenses and stereo pair before their elimination
  /// (lower triangle of the dense columns), and the frames' mount Jacobians: only if the
  /// calibration is a variable. Otherwise it is part of `equations`.
  MatrixXd vision_H;
  VectorXd vision_b;
  MountJacobians mounts;
  LensSums lens_sums;
  /// For each frame with a motion: what the factors on that motion touch.
  std::vector<VariableSet> coupled_with_motion;
  /// Information of the measurements on each plane, poses given: two tangent directions, offset.
  std::vector<Matrix3d> measured;
  double loss_width = 0;  ///< of reprojections (FactorNoise)
  double cost = 0;

  const StateLayout& layout() const { return equations.layout; }
};

/// Linearises at the current estimate (frozen variables at theirs). `geometry` must be up to date.
void Linearize(const SlidingWindow& window,
               const FrameGeometry& geometry,
               const FactorNoise& noise,
               CalibrationStep calibration_step,
               LinearizedWindow& linear);

/// Cost of the same factors. `geometry` must be up to date.
double WindowCost(const SlidingWindow& window,
                  const FrameGeometry& geometry,
                  const FactorNoise& noise);

}  // namespace facet
