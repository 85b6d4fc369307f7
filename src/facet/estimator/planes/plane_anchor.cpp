// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_anchor.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "facet/estimator/window/prior_walk.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

// H <- S^T H S and b <- S^T b, S = T^-1 on the columns of one plane and identity elsewhere.
void ChangeVariables(const Matrix3d& S, int offset, MarginalPrior& prior) {
  prior.H.middleCols<3>(offset) = (prior.H.middleCols<3>(offset) * S).eval();
  prior.H.middleRows<3>(offset) = (S.transpose() * prior.H.middleRows<3>(offset)).eval();
  prior.b.segment<3>(offset) = (S.transpose() * prior.b.segment<3>(offset)).eval();
}

// The landmarks of a plane.
struct LandmarkCloud {
  Vector3d sum_W = Vector3d::Zero();
  double sum_of_squares_m2 = 0;
  int num = 0;

  Vector3d mean_W() const { return sum_W / num; }
  double spread_m() const {
    constexpr double kLeast_m = 0.01;
    const double variance = sum_of_squares_m2 / num - mean_W().squaredNorm();
    return std::max(std::sqrt(std::max(variance, 0.0)), kLeast_m);
  }
};

std::vector<LandmarkCloud> LandmarkClouds(const SlidingWindow& window) {
  std::vector<LandmarkCloud> clouds(window.planes.size());
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.IsOnPlanes()) continue;
    const Vector3d p_W = window.PositionOf(landmark);
    for (const int plane : landmark.planes) {
      LandmarkCloud& cloud = clouds[static_cast<std::size_t>(plane)];
      cloud.sum_W += p_W;
      cloud.sum_of_squares_m2 += p_W.squaredNorm();
      ++cloud.num;
    }
  }
  return clouds;
}

// What is seen now of an uneven surface is another piece of it (docs/math.md, equation (7.6)).
void ForgetUnevenSurface(double moved_m, double spread_m, int index, SlidingWindow& window) {
  const WindowPlane& plane = window.planes[index];
  const double sigma_m = plane.unevenness_m, sigma_rad = sigma_m / spread_m;
  const Vector3d variances =
      moved_m / spread_m *
      Vector3d(sigma_rad * sigma_rad, sigma_rad * sigma_rad, sigma_m * sigma_m);
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    if (block.kind == Variable::Kind::kPlane && block.plane == plane.id)
      TakeRandomStep<3>(block.offset, variances.asDiagonal(), window.prior);
  }
}

}  // namespace

void MoveAnchor(const Vector3d& anchor_W, int index, SlidingWindow& window) {
  WindowPlane& plane = window.planes[index];
  const Vector3d shift_W = anchor_W - plane.anchor_W;
  // Equations (7.4) and (7.5): e' = e - n . shift, so de' = de - shift^T B du.
  const Eigen::RowVector2d lever = shift_W.transpose() * TangentBasis(plane.n_lin);
  plane.anchor_W = anchor_W;
  plane.offset -= plane.n.dot(shift_W);
  plane.delta.z() -= lever * plane.delta.head<2>();
  Matrix3d S = Matrix3d::Identity();
  S.bottomLeftCorner<1, 2>() = lever;
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    if (block.kind == Variable::Kind::kPlane && block.plane == plane.id)
      ChangeVariables(S, block.offset, window.prior);
  }
  for (WindowRelation& relation : window.relations) {
    if (relation.relation.Involves(plane.id)) window.AttachRelation(relation);
  }
}

int FollowLandmarks(double max_distance_m, SlidingWindow& window) {
  constexpr int kMinMembers = 3;
  const std::vector<LandmarkCloud> clouds = LandmarkClouds(window);
  int moved = 0;
  for (std::size_t k = 0; k < window.planes.size(); ++k) {
    if (clouds[k].num < kMinMembers) continue;
    const bool is_uneven = window.planes[k].unevenness_m > 0;
    const double spread_m = clouds[k].spread_m();
    const double moved_m = (clouds[k].mean_W() - window.planes[k].anchor_W).norm();
    if (moved_m <= (is_uneven ? std::min(spread_m, max_distance_m) : max_distance_m)) continue;
    MoveAnchor(clouds[k].mean_W(), static_cast<int>(k), window);
    if (is_uneven) ForgetUnevenSurface(moved_m, spread_m, static_cast<int>(k), window);
    ++moved;
  }
  return moved;
}

}  // namespace facet
