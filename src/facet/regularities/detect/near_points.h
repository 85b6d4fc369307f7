// SPDX-License-Identifier: BSD-2-Clause
// Which of many points are near a plane: one coordinate after the other, a few points at a time.
#pragma once

#include <algorithm>
#include <cstddef>

#include "facet/geometry/plane.h"

namespace facet {

class NearPoints {
 public:
  /// `position` is called for 0 to size - 1. A point that is not finite is near nothing.
  template <class Position>
  NearPoints(std::size_t size, const Position& position)
      : size_(size), points_W_(static_cast<Eigen::Index>((size + kStep - 1) / kStep * kStep), 3) {
    points_W_.bottomRows(std::min<Eigen::Index>(kStep, points_W_.rows())).setConstant(kFarAway_m);
    for (std::size_t i = 0; i < size; ++i) {
      const Vector3d& p_W = position(i);
      auto row = points_W_.row(static_cast<Eigen::Index>(i));
      if (p_W.allFinite()) {
        row = p_W.transpose().array();
      } else {
        row = kFarAway_m;
      }
    }
  }

  /// Calls function(i) for the points within `max_m`, in ascending order.
  template <class Function>
  void ForEachNear(const Plane& plane_W, double max_m, const Function& function) const {
    using Step = Eigen::Array<double, kStep, 1>;
    for (Eigen::Index first = 0; first < points_W_.rows(); first += kStep) {
      const Step distances_m = (points_W_.col(0).segment<kStep>(first) * plane_W.n.x() +
                                points_W_.col(1).segment<kStep>(first) * plane_W.n.y() +
                                points_W_.col(2).segment<kStep>(first) * plane_W.n.z() - plane_W.d)
                                   .abs();
      if (!(distances_m.minCoeff() <= max_m)) continue;  // most often
      for (Eigen::Index k = 0; k < kStep; ++k) {
        const auto i = static_cast<std::size_t>(first + k);
        if (i < size_ && distances_m[k] <= max_m) function(i);
      }
    }
  }

 private:
  static constexpr int kStep = 8;
  static constexpr double kFarAway_m = 1e9;
  std::size_t size_;
  Eigen::ArrayX3d points_W_;
};

}  // namespace facet
