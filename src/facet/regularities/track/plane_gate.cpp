// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/plane_gate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "facet/geometry/so3.h"

namespace facet {

namespace {

// d (n . (p - anchor) - offset) for p fixed in the body.
Matrix<1, 10> DistanceJacobian(const PlaneEstimate& plane, const SE3& T_WB, const Vector3d& p_W) {
  const Vector3d& n = plane.plane_W.n;
  const Vector3d p_B = T_WB.q.conjugate() * (p_W - T_WB.p);
  Matrix<1, 10> J;
  J.head<3>() = -n.transpose() * T_WB.R() * Hat(p_B);
  J.segment<3>(3) = n.transpose();
  J.segment<3>(6) = (p_W - plane.anchor_W).transpose();
  J(9) = -1;
  return J;
}

// d (B^T (m - n), n . (p - anchor) - offset) for a direction m and a point p fixed in the body.
Matrix<3, 10> MeasurementJacobian(const PlaneEstimate& plane,
                                  const Matrix<3, 2>& B,
                                  const SE3& T_WB,
                                  const Vector3d& m_W,
                                  const Vector3d& p_W) {
  Matrix<3, 10> J = Matrix<3, 10>::Zero();
  J.block<2, 3>(0, 0) = -B.transpose() * T_WB.R() * Hat(T_WB.q.conjugate() * m_W);
  J.block<2, 3>(0, 6) = -B.transpose();
  J.row(2) = DistanceJacobian(plane, T_WB, p_W);
  return J;
}

double SquaredMahalanobis(const Matrix3d& covariance, const Vector3d& r) {
  const Eigen::LLT<Matrix3d> factor(covariance);
  if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  const double square = factor.matrixL().solve(r).squaredNorm();
  return std::isfinite(square) ? square : std::numeric_limits<double>::infinity();
}

}  // namespace

// The Jacobian is affine in p_W.
DistanceUncertainty::DistanceUncertainty(const PlaneEstimate& plane, const SE3& T_WB) {
  Matrix<10, 4> K;
  K.col(3) = DistanceJacobian(plane, T_WB, Vector3d::Zero()).transpose();
  for (int i = 0; i < 3; ++i)
    K.col(i) = DistanceJacobian(plane, T_WB, Vector3d::Unit(i)).transpose() - K.col(3);
  // About the body, so that a world far from its origin costs no digits.
  K.col(3) += K.leftCols<3>() * T_WB.p;
  body_W_ = T_WB.p;
  form_ = K.transpose() * plane.covariance * K;
}

double DistanceUncertainty::VarianceAt(const Vector3d& p_W) const {
  const Vector4d p((p_W - body_W_).homogeneous());
  return std::max(p.dot(form_ * p), 0.0);
}

double DistanceVariance(const PlaneEstimate& plane, const SE3& T_WB, const Vector3d& p_W) {
  const Matrix<1, 10> J = DistanceJacobian(plane, T_WB, p_W);
  return std::max((J * plane.covariance * J.transpose())(0), 0.0);
}

double ChiSquare(const PlaneCandidate& candidate, const PlaneEstimate& plane, const SE3& T_WB) {
  const Vector3d& n = plane.plane_W.n;
  if (candidate.plane_W.n.dot(n) < 0) return std::numeric_limits<double>::infinity();
  const Matrix<3, 2> B = TangentBasis(n);
  const Vector3d& m_W = candidate.plane_W.n;
  Vector3d r;
  r.head<2>() = B.transpose() * (m_W - n);
  r(2) = plane.plane_W.SignedDistance(candidate.centroid_W);
  const Matrix<3, 10> J = MeasurementJacobian(plane, B, T_WB, m_W, candidate.centroid_W);
  Matrix3d covariance = J * plane.covariance * J.transpose();
  covariance.topLeftCorner<2, 2>() += B.transpose() * candidate.normal_covariance * B;
  covariance(2, 2) += candidate.offset_variance_m2;
  return SquaredMahalanobis(covariance, r);
}

double ChiSquare(const PlaneEstimate& a,
                 const PlaneEstimate& b,
                 const Vector3d& p_W,
                 const SE3& T_WB) {
  if (a.plane_W.n.dot(b.plane_W.n) < 0) return std::numeric_limits<double>::infinity();
  const Matrix<3, 2> B = TangentBasis(a.plane_W.n);
  Vector3d r;
  r.head<2>() = B.transpose() * (b.plane_W.n - a.plane_W.n);
  r(2) = a.plane_W.SignedDistance(p_W) - b.plane_W.SignedDistance(p_W);
  const Matrix<3, 10> J_a = MeasurementJacobian(a, B, T_WB, a.plane_W.n, p_W);
  const Matrix<3, 10> J_b = MeasurementJacobian(b, B, T_WB, b.plane_W.n, p_W);
  return SquaredMahalanobis(
      J_a * a.covariance * J_a.transpose() + J_b * b.covariance * J_b.transpose(), r);
}

}  // namespace facet
