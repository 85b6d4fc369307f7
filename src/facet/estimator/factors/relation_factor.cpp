// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/relation_factor.h"

#include <cmath>
#include <numbers>

#include "facet/estimator/factors/robust_loss.h"

namespace facet {

namespace {

using Rows = Vector<RelationRows::kMaxRows>;

// Flatter than this (as a length of the normal's horizontal part) a plane has no heading.
constexpr double kMinHorizontal = 0.3;

struct Operands {
  const WindowPlane& a;
  const WindowPlane& b;  // a again if there is only one
  const WindowFrame& frame;
};

Operands Find(const SlidingWindow& window, const WindowRelation& relation) {
  const PlaneRelation& r = relation.relation;
  const WindowPlane& a = window.planes[window.IndexOf(r.a)];
  const WindowPlane& b = r.IsUnary() ? a : window.planes[window.IndexOf(r.b)];
  return {a, b, window.frames[window.IndexOf(relation.frame)]};
}

double HeadingDifference(const Vector3d& n_a, const Vector3d& n_b) {
  return std::atan2(n_a.y(), n_a.x()) - std::atan2(n_b.y(), n_b.x());
}

double Sign(const Operands& of) {
  return of.a.n.dot(of.b.n) < 0 ? -1.0 : 1.0;
}

// Difference of the distances of one point from both planes.
double OffsetDifference(const Operands& of, const Vector3d& c_W) {
  return of.a.SignedDistance(c_W) - Sign(of) * of.b.SignedDistance(c_W);
}

// Without the weight of the loss.
Rows Error(PlaneRelationKind kind,
           const Operands& of,
           const WindowRelation& relation,
           const RelationNoise& noise) {
  Rows r = Rows::Zero();
  const Vector3d &n_a = of.a.n, &n_b = of.b.n;
  const double turn = LogSO3(of.frame.x.T_WB.q * of.frame.lin.T_WB.q.conjugate()).z();
  const Eigen::AngleAxisd carried(-turn, Vector3d::UnitZ());
  switch (kind) {
    case PlaneRelationKind::kCoplanar:
      r(3) = OffsetDifference(of, of.frame.x.T_WB * relation.point_B) / noise.sigma_m;
      [[fallthrough]];
    case PlaneRelationKind::kParallel:
      r.head<3>() = carried * Vector3d(n_a - Sign(of) * n_b) / noise.sigma_rad;
      break;
    case PlaneRelationKind::kOrthogonal:
      r(0) = n_a.dot(n_b) / noise.sigma_rad;
      break;
    case PlaneRelationKind::kHorizontal:
      r.head<2>() = (carried * n_a).head<2>() / noise.gravity_sigma_rad;
      break;
    case PlaneRelationKind::kVertical:
      r(0) = n_a.z() / noise.gravity_sigma_rad;
      break;
    case PlaneRelationKind::kHeadingParallel:
      r(0) = std::remainder(HeadingDifference(n_a, n_b), std::numbers::pi) / noise.sigma_rad;
      break;
    case PlaneRelationKind::kHeadingOrthogonal:
      r(0) =
          std::remainder(HeadingDifference(n_a, n_b) - 0.5 * std::numbers::pi, std::numbers::pi) /
          noise.sigma_rad;
      break;
  }
  return r;
}

bool HasHeading(const Vector3d& n) {
  return n.head<2>().norm() > kMinHorizontal;
}

int NumRows(PlaneRelationKind kind, const Operands& of) {
  switch (kind) {
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
      return HasHeading(of.a.n_lin) && HasHeading(of.b.n_lin) ? 1 : 0;
  }
  return 0;
}

// Derivative of the heading of n with respect to its two tangent directions.
Matrix<1, 2> HeadingJacobian(const Vector3d& n) {
  return Vector3d::UnitZ().cross(n).transpose() * TangentBasis(n) / n.head<2>().squaredNorm();
}

// Equation (8.3): the frame's heading carries a residual that turns with everything.
void AddCarrying(const Operands& of, const Vector3d& r_W, int num_rows, RelationRows& rows) {
  const Matrix3d J = -Vector3d::UnitZ().cross(r_W) *
                     (of.frame.lin.T_WB.q.conjugate() * Vector3d::UnitZ()).transpose();
  rows.J_frame.block(0, 0, num_rows, 3) = J.topRows(num_rows);
}

void ParallelJacobians(const Operands& of, const RelationNoise& noise, RelationRows& rows) {
  const double s = Sign(of), w = 1 / noise.sigma_rad;
  rows.J_a.topLeftCorner<3, 2>() = w * TangentBasis(of.a.n_lin);
  rows.J_b.topLeftCorner<3, 2>() = -s * w * TangentBasis(of.b.n_lin);
  AddCarrying(of, w * (of.a.n_lin - s * of.b.n_lin), 3, rows);
}

// Equation (8.4), the last row of coplanar planes.
void OffsetJacobians(const Operands& of,
                     const Vector3d& point_B,
                     const RelationNoise& noise,
                     RelationRows& rows) {
  const double s = Sign(of), w = 1 / noise.sigma_m;
  const SE3& T_WB = of.frame.lin.T_WB;
  const Vector3d c_W = T_WB * point_B;
  const Vector3d difference = of.a.n_lin - s * of.b.n_lin;
  rows.J_a.row(3) << w * (c_W - of.a.anchor_W).transpose() * TangentBasis(of.a.n_lin), -w;
  rows.J_b.row(3) << -s * w * (c_W - of.b.anchor_W).transpose() * TangentBasis(of.b.n_lin), s * w;
  // c = p + R point_B, so dc = dp - R Hat(point_B) dtheta.
  const Matrix3d R_Hat = T_WB.R() * Hat(point_B);
  rows.J_frame.row(3) << -w * difference.transpose() * R_Hat, w * difference.transpose();
}

void Jacobians(const WindowRelation& relation,
               const Operands& of,
               const RelationNoise& noise,
               RelationRows& rows) {
  const Vector3d &n_a = of.a.n_lin, &n_b = of.b.n_lin;
  switch (relation.relation.kind) {
    case PlaneRelationKind::kCoplanar:
      ParallelJacobians(of, noise, rows);
      OffsetJacobians(of, relation.point_B, noise, rows);
      break;
    case PlaneRelationKind::kParallel:
      ParallelJacobians(of, noise, rows);
      break;
    case PlaneRelationKind::kOrthogonal:
      rows.J_a.row(0).head<2>() = n_b.transpose() * TangentBasis(n_a) / noise.sigma_rad;
      rows.J_b.row(0).head<2>() = n_a.transpose() * TangentBasis(n_b) / noise.sigma_rad;
      break;
    case PlaneRelationKind::kHorizontal:
      rows.J_a.topLeftCorner<2, 2>() = TangentBasis(n_a).topRows<2>() / noise.gravity_sigma_rad;
      AddCarrying(of, n_a / noise.gravity_sigma_rad, 2, rows);
      break;
    case PlaneRelationKind::kVertical:
      rows.J_a.row(0).head<2>() = TangentBasis(n_a).row(2) / noise.gravity_sigma_rad;
      break;
    case PlaneRelationKind::kHeadingParallel:
    case PlaneRelationKind::kHeadingOrthogonal:
      rows.J_a.row(0).head<2>() = HeadingJacobian(n_a) / noise.sigma_rad;
      rows.J_b.row(0).head<2>() = -HeadingJacobian(n_b) / noise.sigma_rad;
      break;
  }
}

}  // namespace

bool NeedsFrame(PlaneRelationKind kind) {
  return kind == PlaneRelationKind::kParallel || kind == PlaneRelationKind::kCoplanar ||
         kind == PlaneRelationKind::kHorizontal;
}

Vector<RelationRows::kMaxRows> RelationError(const SlidingWindow& window,
                                             const WindowRelation& relation,
                                             const RelationNoise& noise) {
  const Operands of = Find(window, relation);
  const PlaneRelationKind kind = relation.relation.kind;
  if (NumRows(kind, of) == 0) return Rows::Zero();
  return Error(kind, of, relation, noise);
}

RelationRows LinearizeRelation(const SlidingWindow& window,
                               const WindowRelation& relation,
                               const RelationNoise& noise) {
  const Operands of = Find(window, relation);
  const PlaneRelationKind kind = relation.relation.kind;
  RelationRows rows;
  rows.num_rows = NumRows(kind, of);
  if (rows.num_rows == 0) return rows;
  rows.r = Error(kind, of, relation, noise);
  Jacobians(relation, of, noise, rows);
  const RobustLoss loss = HuberLoss(rows.r.norm(), noise.huber_sigma);
  rows.cost = loss.cost;
  rows.r *= loss.root_weight;
  rows.J_a *= loss.root_weight;
  rows.J_b *= loss.root_weight;
  rows.J_frame *= loss.root_weight;
  return rows;
}

int DropViolatedRelations(const RelationNoise& noise, double max_sigma, SlidingWindow& window) {
  return static_cast<int>(std::erase_if(window.relations, [&](const WindowRelation& relation) {
    return RelationError(window, relation, noise).norm() > max_sigma;
  }));
}

}  // namespace facet
