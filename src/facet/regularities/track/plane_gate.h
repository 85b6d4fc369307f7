// SPDX-License-Identifier: BSD-2-Clause
// Gates between tracked planes and what the newest keyframe shows, from the joint covariance of
// plane and newest pose: after a round trip a plane may be known to a millimetre in the world and
// still be 10 cm away from where the camera is expected to see it.
#pragma once

#include <cmath>
#include <numbers>

#include "facet/regularities/detect/plane_candidate.h"

namespace facet {

/// 1-sigma of what stands out of a surface that is a plane: prints, frames, panels [m].
inline constexpr double kRelief_m = 0.01;

/// Squared distance from a plane up to which a vertex of the mesh is on it [m^2]: there it is as
/// likely to be on this plane as to be on something else (docs/math.md, 7.3). On the plane the
/// distance has `variance_m2`, from vertex and plane, and the plane's relief; on something else it
/// is uniformly distributed. No gate is wider than `max_distance_m` (DetectionOptions), and a
/// vertex that is known worse than to sqrt(e) times that is on no plane. Lengths are those at the
/// vertex's `length_scale`.
inline double SquaredGate(double variance_m2, double max_distance_m, double length_scale) {
  const double relief_m = length_scale * kRelief_m, most_m = length_scale * max_distance_m;
  const double variance = variance_m2 + relief_m * relief_m;
  const double worst_variance = std::numbers::e * most_m * most_m;
  return variance < worst_variance ? variance * std::log(worst_variance / variance) : 0;
}

/// Variance of the distance between one plane and any points that are fixed to the camera: for many
/// points at a small cost each.
class DistanceUncertainty {
 public:
  DistanceUncertainty(const PlaneEstimate& plane, const SE3& T_WB);

  /// Of a point that is now at p_W [m^2].
  double VarianceAt(const Vector3d& p_W) const;

 private:
  Vector3d body_W_;
  Matrix4d form_;  // the variance is a quadratic form of (p_W - body_W, 1)
};

/// Variance of the distance between the plane and a point that is fixed to the camera and now at
/// p_W [m^2].
double DistanceVariance(const PlaneEstimate& plane, const SE3& T_WB, const Vector3d& p_W);

/// Squared Mahalanobis distance between a candidate and a plane: normal (2 degrees of freedom) and
/// distance at the candidate's centroid. Infinite when the covariance cannot be inverted and when
/// the two are seen from different sides: normals point to where a surface was seen from.
double ChiSquare(const PlaneCandidate& candidate, const PlaneEstimate& plane, const SE3& T_WB);

/// The same between two planes, compared at the point p_W as the camera sees both. Their errors are
/// also correlated through earlier poses, which is not known here: the result is rather too small.
double ChiSquare(const PlaneEstimate& a,
                 const PlaneEstimate& b,
                 const Vector3d& p_W,
                 const SE3& T_WB);

}  // namespace facet
