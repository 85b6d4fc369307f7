// SPDX-License-Identifier: BSD-2-Clause
// How careful was a calibration? What measurements say of many parameters together tells whether
// their errors are as large as was believed before, or smaller (docs/math.md, section 10.10).
#pragma once

#include "facet/base/types.h"

namespace facet {

/// What is known of a group of parameters.
struct GroupEstimate {
  VectorXd mean;        ///< deviation from what was given
  MatrixXd covariance;  ///< with a prior of zero mean and `share` times the first covariance
  double share = 1;
};

/// The share of `first`, the covariance that was believed before any measurement, that this group
/// has by now turned out to have: the mean over all that are possible, weighted by how well they
/// explain the estimate. Between 0.01 and 1; 1 is believed by nine to one until something else is
/// shown, and other shares with any order of magnitude alike. `estimate.share` where matrices are
/// no covariances.
double BelievedShare(const MatrixXd& first, const GroupEstimate& estimate);

}  // namespace facet
