// SPDX-License-Identifier: BSD-2-Clause
// A variable that the prior knows is from now on another one than before.
#pragma once

#include <Eigen/LU>

#include "facet/estimator/window/window_priors.h"

namespace facet {

/// The variable with its columns at `offset` takes a random step with this covariance, and what it
/// was before is marginalised (docs/math.md, equation (10.6)): with W the covariance and c the
/// columns, the Schur complement is H - H_c (I + W H_cc)^-1 W H_c^T, which needs no inverse of W.
template <int kSize>
void TakeRandomStep(int offset, const Matrix<kSize, kSize>& covariance, MarginalPrior& prior) {
  const Eigen::Matrix<double, Eigen::Dynamic, kSize> H_c = prior.H.middleCols<kSize>(offset);
  const Matrix<kSize, kSize> H_cc = H_c.template middleRows<kSize>(offset);
  const Matrix<kSize, kSize> gain =
      (Matrix<kSize, kSize>::Identity() + covariance * H_cc).partialPivLu().solve(covariance);
  const Matrix<kSize, kSize> symmetric = 0.5 * (gain + gain.transpose());
  const Vector<kSize> b_c = prior.b.segment<kSize>(offset);
  prior.b -= H_c * (symmetric * b_c);
  prior.H -= H_c * symmetric * H_c.transpose();
}

}  // namespace facet
