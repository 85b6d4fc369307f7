// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_anchor.h"

#include "facet/geometry/so3.h"

namespace facet {

namespace {

// H <- S^T H S and b <- S^T b, S = T^-1 on the columns of one plane and identity elsewhere.
void ChangeVariables(const Matrix3d& S, int offset, MarginalPrior& prior) {
  prior.H.middleCols<3>(offset) = (prior.H.middleCols<3>(offset) * S).eval();
  prior.H.middleRows<3>(offset) = (S.transpose() * prior.H.middleRows<3>(offset)).eval();
  prior.b.segment<3>(offset) = (S.transpose() * prior.b.segment<3>(offset)).eval();
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
  std::vector<Vector3d> sums(window.planes.size(), Vector3d::Zero());
  std::vector<int> counts(window.planes.size(), 0);
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.IsOnPlanes()) continue;
    const Vector3d p_W = window.PositionOf(landmark);
    for (const int plane : landmark.planes) {
      sums[static_cast<std::size_t>(plane)] += p_W;
      ++counts[static_cast<std::size_t>(plane)];
    }
  }
  int moved = 0;
  for (std::size_t k = 0; k < window.planes.size(); ++k) {
    if (counts[k] < kMinMembers) continue;
    const Vector3d mean_W = sums[k] / counts[k];
    if ((mean_W - window.planes[k].anchor_W).norm() <= max_distance_m) continue;
    MoveAnchor(mean_W, static_cast<int>(k), window);
    ++moved;
  }
  return moved;
}

}  // namespace facet
