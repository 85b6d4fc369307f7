// SPDX-License-Identifier: BSD-2-Clause
// Takes a landmark out of the normal equations of frames and planes, and puts it back after the
// solve (docs/math.md, section 4.2). Landmarks are eliminated one by one: they are "structureless".
#pragma once

#include "facet/estimator/factors/landmark_block.h"
#include "facet/estimator/window/state_layout.h"

namespace facet {

/// Adds what the landmark's rows say about frames and planes themselves: blocks on the diagonal.
void AddDiagonal(const LandmarkBlock& block, const StateLayout& layout, MatrixXd& H, VectorXd& b);

/// Factorises V (damped by lambda times its diagonal) and prepares Y and z of all views.
void Eliminate(double lambda, LandmarkBlock& block);

/// Subtracts the eliminated landmark from (H, b), equation (4.3); lower triangle of plane and pose
/// columns only.
void SubtractSchur(const LandmarkBlock& block, const StateLayout& layout, MatrixXd& H, VectorXd& b);

/// The landmark's own step, equation (4.4), when frames and planes take `step`.
Vector3d BackSubstitute(const LandmarkBlock& block,
                        const StateLayout& layout,
                        const VectorXd& step);

}  // namespace facet
