// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/relation_factor.h"

#include <cmath>
#include <numbers>

#include "facet/estimator/factors/robust_loss.h"
#include "facet/geometry/so3.h"

namespace facet {

static_assert(Factor<RelationFactor>);

namespace {

using Rows = Vector<RelationRows::kMaxRows>;

// Flatter than this (as a length of the normal's horizontal part) a plane has no heading.
constexpr double kMinHorizontal = 0.3;

double HeadingDifference(const Vector3d& n_a, const Vector3d& n_b) {
  return std::atan2(n_a.y(), n_a.x()) - std::atan2(n_b.y(), n_b.x());
}

bool HasHeading(const Vector3d& n) {
  return n.head<2>().norm() > kMinHorizontal;
}

// Equation (8.1): derivative of the heading of n with respect to its two tangent directions.
Matrix<1, 2> HeadingJacobian(const Vector3d& n) {
  return Vector3d::UnitZ().cross(n).transpose() * TangentBasis(n) / n.head<2>().squaredNorm();
}

Variable SecondPlane(const SlidingWindow& window, const PlaneRelation& relation) {
  return Variable::Plane(window.IndexOf(relation.IsUnary() ? relation.a : relation.b));
}

}  // namespace

RelationFactor::RelationFactor(const SlidingWindow& window,
                               const WindowRelation& relation,
                               const RelationNoise& noise)
    : relation_(relation),
      noise_(noise),
      plane_a_(Variable::Plane(window.IndexOf(relation.relation.a))),
      plane_b_(SecondPlane(window, relation.relation)),
      pose_(Variable::Pose(window.IndexOf(relation.frame))),
      a_(window.planes[plane_a_.index]),
      b_(window.planes[plane_b_.index]),
      frame_(window.frames[pose_.index]) {}

bool RelationFactor::NeedsFrame() const {
  return kind() == PlaneRelationKind::kParallel || kind() == PlaneRelationKind::kCoplanar ||
         kind() == PlaneRelationKind::kHorizontal;
}

int RelationFactor::NumRows() const {
  switch (kind()) {
    case PlaneRelationKind::kCoplanar:
      return 4;
    case PlaneRelationKind::kParallel:
      return 3;
    case PlaneRelationKind::kHorizontal:
      return 2;
    case PlaneRelationKind::kOrthogonal:
    case PlaneRelationKind::kVertical:
      return 1;
    case PlaneRelationKind::kHeadingParallel:
    case PlaneRelationKind::kHeadingOrthogonal:
      return HasHeading(a_.n_lin) && HasHeading(b_.n_lin) ? 1 : 0;
  }
  return 0;
}

double RelationFactor::Sign() const {
  return a_.n.dot(b_.n) < 0 ? -1.0 : 1.0;
}

// Difference of the distances of one point from both planes.
double RelationFactor::OffsetDifference(const Vector3d& c_W) const {
  return a_.SignedDistance(c_W) - Sign() * b_.SignedDistance(c_W);
}

// The table of section 8, carried along by the frame (8.2); without the weight of the loss.
Rows RelationFactor::WhitenedError() const {
  Rows r = Rows::Zero();
  const Vector3d &n_a = a_.n, &n_b = b_.n;
  const double turn = LogSO3(frame_.x.T_WB.q * frame_.lin.T_WB.q.conjugate()).z();
  const Eigen::AngleAxisd carried(-turn, Vector3d::UnitZ());
  switch (kind()) {
    case PlaneRelationKind::kCoplanar:
      r(3) = OffsetDifference(frame_.x.T_WB * relation_.point_B) / noise_.sigma_m;
      [[fallthrough]];
    case PlaneRelationKind::kParallel:
      r.head<3>() = carried * Vector3d(n_a - Sign() * n_b) / noise_.sigma_rad;
      break;
    case PlaneRelationKind::kOrthogonal:
      r(0) = n_a.dot(n_b) / noise_.sigma_rad;
      break;
    case PlaneRelationKind::kHorizontal:
      r.head<2>() = (carried * n_a).head<2>() / noise_.gravity_sigma_rad;
      break;
    case PlaneRelationKind::kVertical:
      r(0) = n_a.z() / noise_.gravity_sigma_rad;
      break;
    case PlaneRelationKind::kHeadingParallel:
      r(0) = std::remainder(HeadingDifference(n_a, n_b), std::numbers::pi) / noise_.sigma_rad;
      break;
    case PlaneRelationKind::kHeadingOrthogonal:
      r(0) =
          std::remainder(HeadingDifference(n_a, n_b) - 0.5 * std::numbers::pi, std::numbers::pi) /
          noise_.sigma_rad;
      break;
  }
  return r;
}

// Equation (8.3): the frame's heading carries a residual that turns with everything.
void RelationFactor::SetFrameJacobian(const Vector3d& r_W, int num_rows, RelationRows& rows) const {
  const Matrix3d J = -Vector3d::UnitZ().cross(r_W) *
                     (frame_.lin.T_WB.q.conjugate() * Vector3d::UnitZ()).transpose();
  rows.J_frame.block(0, 0, num_rows, 3) = J.topRows(num_rows);
}

void RelationFactor::SetParallelJacobians(RelationRows& rows) const {
  const double s = Sign(), w = 1 / noise_.sigma_rad;
  rows.J_a.topLeftCorner<3, 2>() = w * TangentBasis(a_.n_lin);
  rows.J_b.topLeftCorner<3, 2>() = -s * w * TangentBasis(b_.n_lin);
  SetFrameJacobian(w * (a_.n_lin - s * b_.n_lin), 3, rows);
}

// Equation (8.4), the last row of coplanar planes.
void RelationFactor::SetOffsetJacobians(RelationRows& rows) const {
  const double s = Sign(), w = 1 / noise_.sigma_m;
  const SE3& T_WB = frame_.lin.T_WB;
  const Vector3d c_W = T_WB * relation_.point_B;
  const Vector3d difference = a_.n_lin - s * b_.n_lin;
  rows.J_a.row(3) << w * (c_W - a_.anchor_W).transpose() * TangentBasis(a_.n_lin), -w;
  rows.J_b.row(3) << -s * w * (c_W - b_.anchor_W).transpose() * TangentBasis(b_.n_lin), s * w;
  // c = p + R point_B, so dc = dp - R Hat(point_B) dtheta.
  const Matrix3d R_Hat = T_WB.R() * Hat(relation_.point_B);
  rows.J_frame.row(3) << -w * difference.transpose() * R_Hat, w * difference.transpose();
}

void RelationFactor::SetJacobians(RelationRows& rows) const {
  const Vector3d &n_a = a_.n_lin, &n_b = b_.n_lin;
  switch (kind()) {
    case PlaneRelationKind::kCoplanar:
      SetParallelJacobians(rows);
      SetOffsetJacobians(rows);
      break;
    case PlaneRelationKind::kParallel:
      SetParallelJacobians(rows);
      break;
    case PlaneRelationKind::kOrthogonal:
      rows.J_a.row(0).head<2>() = n_b.transpose() * TangentBasis(n_a) / noise_.sigma_rad;
      rows.J_b.row(0).head<2>() = n_a.transpose() * TangentBasis(n_b) / noise_.sigma_rad;
      break;
    case PlaneRelationKind::kHorizontal:
      rows.J_a.topLeftCorner<2, 2>() = TangentBasis(n_a).topRows<2>() / noise_.gravity_sigma_rad;
      SetFrameJacobian(n_a / noise_.gravity_sigma_rad, 2, rows);
      break;
    case PlaneRelationKind::kVertical:
      rows.J_a.row(0).head<2>() = TangentBasis(n_a).row(2) / noise_.gravity_sigma_rad;
      break;
    case PlaneRelationKind::kHeadingParallel:
    case PlaneRelationKind::kHeadingOrthogonal:
      rows.J_a.row(0).head<2>() = HeadingJacobian(n_a) / noise_.sigma_rad;
      rows.J_b.row(0).head<2>() = -HeadingJacobian(n_b) / noise_.sigma_rad;
      break;
  }
}

Rows RelationFactor::Error() const {
  return NumRows() == 0 ? Rows(Rows::Zero()) : WhitenedError();
}

RelationRows RelationFactor::Linearize() const {
  RelationRows rows;
  rows.num_rows = NumRows();
  if (rows.num_rows == 0) return rows;
  rows.r = WhitenedError();
  SetJacobians(rows);
  const RobustLoss loss = HuberLoss(rows.r.norm(), noise_.huber_sigma);
  rows.cost = loss.cost;
  rows.r *= loss.root_weight;
  rows.J_a *= loss.root_weight;
  rows.J_b *= loss.root_weight;
  rows.J_frame *= loss.root_weight;
  return rows;
}

double RelationFactor::Cost() const {
  return HuberLoss(Error().norm(), noise_.huber_sigma).cost;
}

double RelationFactor::AddTo(NormalEquations& equations) const {
  const RelationRows rows = Linearize();
  equations.AddSquare(plane_a_, rows.J_a, rows.r);
  if (IsBinary()) {
    equations.AddSquare(plane_b_, rows.J_b, rows.r);
    equations.AddProduct(plane_a_, rows.J_a, plane_b_, rows.J_b);
  }
  if (!NeedsFrame()) return rows.cost;
  equations.AddSquare(pose_, rows.J_frame, rows.r);
  equations.AddProduct(plane_a_, rows.J_a, pose_, rows.J_frame);
  if (IsBinary()) equations.AddProduct(plane_b_, rows.J_b, pose_, rows.J_frame);
  return rows.cost;
}

}  // namespace facet
