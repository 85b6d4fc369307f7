// SPDX-License-Identifier: BSD-2-Clause
// Whether the images turn as fast as the gyroscope says. Focal lengths that are one per cent too
// long make every turn of the images one per cent too small, and so does a gyroscope whose scale is
// that much too large; an estimator that trusts its calibration gives way only slowly.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "facet/base/types.h"
#include "facet/plausibility/robust_line.h"

namespace facet {

/// How the body turned from one keyframe to the next, in its own frame before it.
struct DoubleTurn {
  Vector3d by_images = Vector3d::Zero(), by_gyro = Vector3d::Zero();  ///< [rad], rotation vectors
  double dt_s = 0;
};

/// Not thread-safe.
class TurnCheck {
 public:
  /// Turns of the images over those of the gyroscope.
  using Ratio = FactorBounds;

  /// True once, when the ratio is off and has been so for a while.
  bool Add(const DoubleTurn& turn);

  /// Empty before the body has turned enough to say anything.
  const std::optional<Ratio>& ratio() const { return ratio_; }

  /// For certain no axis of the gyroscope is negated, or exchanged for another one.
  bool DoAxesAgree() const { return do_axes_agree_; }

  /// Nothing more is to be learnt.
  bool IsDone() const;

 private:
  struct Row {
    int axis = 0;  // of by_images
    double by_images = 0;
    Vector3d by_gyro;
    Vector3d constants;  // derivatives by what is left of the gyroscope's bias
  };

  std::optional<Ratio> Fit() const;
  bool FindWhetherAxesAgree() const;

  std::vector<Row> rows_;
  std::optional<Ratio> ratio_;
  int num_doubts_ = 0;  // in a row
  bool has_doubted_ = false, do_axes_agree_ = false;
};

/// What is wrong, in words that follow "warning: ".
std::string TurnsInWords(const TurnCheck::Ratio& ratio);

}  // namespace facet
