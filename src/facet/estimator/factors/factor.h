// SPDX-License-Identifier: BSD-2-Clause
// The interface of every factor between frames and planes.
#pragma once

#include <concepts>

#include "facet/estimator/factors/normal_equations.h"
#include "facet/estimator/window/marginalization_plan.h"

namespace facet {

/// A factor is a small view of one measurement in a window, made where it is needed and valid as
/// long as the window is not changed. Its residual is predicted minus measured, at the estimate and
/// whitened; its Jacobians are taken at the linearisation points (WindowFrame::lin,
/// WindowPlane::n_lin); rows and residual are multiplied with the root of the weight of its robust
/// loss. It knows no solver.
///
/// Cost: 1/2 |r|^2 or the robust loss, at the estimate.
/// AddTo: adds J^T J and J^T r in the columns of its variables; returns the cost.
/// IsUsedUp: whether a marginalisation takes the factor up: it is linearised once more, becomes
/// part of the prior, and leaves the window together with the variable that it loses.
/// ForEachVariable: calls a visitor with each variable that AddTo touches.
///
/// Factors on landmarks are another kind: see landmark_factors.h.
template <class F>
concept Factor = requires(const F& factor,
                          NormalEquations& equations,
                          const MarginalizationPlan& plan) {
  { factor.Cost() } -> std::same_as<double>;
  { factor.AddTo(equations) } -> std::same_as<double>;
  { factor.IsUsedUp(plan) } -> std::same_as<bool>;
  factor.ForEachVariable([](Variable) {});
};

}  // namespace facet
