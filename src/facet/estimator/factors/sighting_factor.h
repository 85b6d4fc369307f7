// SPDX-License-Identifier: BSD-2-Clause
// Rows of the sightings of planes (docs/math.md, section 9): what one keyframe measured of a plane
// as a whole. They touch that keyframe's pose and the plane, and no landmark.
#pragma once

#include "facet/estimator/factors/factor.h"

namespace facet {

/// Residual and Jacobians of one sighting, whitened and weighted.
struct SightingRows {
  Vector3d r = Vector3d::Zero();  ///< distance at the centre, slopes
  Matrix<3, 6> J_pose = Matrix<3, 6>::Zero();
  Matrix3d J_plane = Matrix3d::Zero();  ///< two directions, offset
  double cost = 0;
};

/// The sigmas come with the sighting; norms of the whitened residual beyond `huber_sigma` grow
/// linearly.
class SightingFactor {
 public:
  SightingFactor(const SlidingWindow& window, const PlaneSighting& sighting, double huber_sigma)
      : sighting_(sighting),
        huber_sigma_(huber_sigma),
        plane_(Variable::Plane(window.IndexOf(sighting.plane))),
        pose_(Variable::Pose(window.IndexOf(sighting.frame))),
        sighted_(window.planes[plane_.index]),
        frame_(window.frames[pose_.index]) {}

  /// Whitened, at the estimate.
  Vector3d Error() const;
  SightingRows Linearize() const;

  double Cost() const;
  double AddTo(NormalEquations& equations) const;

  /// With the frame. If the plane alone leaves, what it has been sighted as is lost.
  bool IsUsedUp(const MarginalizationPlan& plan) const { return plan.Drops(pose_); }

  template <class Visitor>
  void ForEachVariable(const Visitor& visit) const {
    visit(plane_);
    visit(pose_);
  }

 private:
  const PlaneSighting& sighting_;
  double huber_sigma_;
  Variable plane_, pose_;
  const WindowPlane& sighted_;
  const WindowFrame& frame_;
};

}  // namespace facet
