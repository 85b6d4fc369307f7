// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/upright_pose.h"

#include <cmath>
#include <numbers>

#include <Eigen/QR>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

Vector3d TurnAboutZ(double c, double s, const Vector3d& x) {
  return {c * x.x() - s * x.y(), s * x.x() + c * x.y(), x.z()};
}

bool IsSeen(const UprightPose& T_BA, const SeenPoint& point, double min_cosine) {
  const Vector3d p_B = T_BA * point.p_A;
  return p_B.dot(point.bearing_B) >= min_cosine * p_B.norm();
}

std::vector<int> Inliers(std::span<const SeenPoint> points,
                         const UprightPose& T_BA,
                         double min_cosine) {
  std::vector<int> inliers;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (IsSeen(T_BA, points[i], min_cosine)) inliers.push_back(static_cast<int>(i));
  }
  return inliers;
}

}  // namespace

Vector3d UprightPose::operator*(const Vector3d& x) const {
  return TurnAboutZ(std::cos(yaw_rad), std::sin(yaw_rad), x) + p;
}

UprightPose UprightPose::operator*(const UprightPose& b) const {
  return {std::remainder(yaw_rad + b.yaw_rad, 2 * std::numbers::pi), *this * b.p};
}

UprightPose UprightPose::Inverse() const {
  return {-yaw_rad, -TurnAboutZ(std::cos(yaw_rad), -std::sin(yaw_rad), p)};
}

SE3 UprightPose::ToSE3() const {
  return {ExpSO3(Vector3d(0, 0, yaw_rad)), p};
}

// Each point gives two equations, one for each direction across its bearing: across . (Rz p + t) =
// 0. The combination of the four that does not hold t is one equation in the heading alone.
std::vector<UprightPose> UprightPosesFromTwo(const SeenPoint& first, const SeenPoint& second) {
  const Matrix<3, 2> across_1 = TangentBasis(first.bearing_B);
  const Matrix<3, 2> across_2 = TangentBasis(second.bearing_B);
  Matrix<4, 3> A;
  A << across_1.transpose(), across_2.transpose();
  const Eigen::ColPivHouseholderQR<Matrix<4, 3>> qr(A);
  if (qr.rank() < 3) return {};
  const Matrix<4, 4> Q = qr.householderQ();
  const Vector4d without_t = Q.col(3);
  const Vector3d a = across_1 * without_t.head<2>(), b = across_2 * without_t.tail<2>();
  const Vector3d &p = first.p_A, &q = second.p_A;
  const double of_cos = a.x() * p.x() + a.y() * p.y() + b.x() * q.x() + b.y() * q.y();
  const double of_sin = a.y() * p.x() - a.x() * p.y() + b.y() * q.x() - b.x() * q.y();
  const double constant = a.z() * p.z() + b.z() * q.z();
  const double length = std::hypot(of_cos, of_sin);
  if (!(length > 1e-9) || std::abs(constant) > length) return {};
  const double middle = std::atan2(of_sin, of_cos), half = std::acos(-constant / length);
  std::vector<UprightPose> poses;
  for (const double yaw : {middle + half, middle - half}) {
    const double c = std::cos(yaw), s = std::sin(yaw);
    const Vector3d turned_1 = TurnAboutZ(c, s, p), turned_2 = TurnAboutZ(c, s, q);
    Vector4d right;
    right << -across_1.transpose() * turned_1, -across_2.transpose() * turned_2;
    const Vector3d t = qr.solve(right);
    if ((turned_1 + t).dot(first.bearing_B) <= 0 || (turned_2 + t).dot(second.bearing_B) <= 0)
      continue;
    poses.push_back({std::remainder(yaw, 2 * std::numbers::pi), t});
  }
  return poses;
}

std::optional<UprightConsensus> FindUprightPose(std::span<const SeenPoint> points,
                                                double max_angle_rad,
                                                int num_trials) {
  const int n = static_cast<int>(points.size());
  if (n < 2) return std::nullopt;
  const double min_cosine = std::cos(max_angle_rad);
  Rng random(1);
  std::optional<UprightConsensus> best;
  for (int trial = 0; trial < num_trials; ++trial) {
    const int i = random.Index(n), j = random.Index(n);
    if (i == j) continue;
    for (const UprightPose& T_BA : UprightPosesFromTwo(points[i], points[j])) {
      std::vector<int> inliers = Inliers(points, T_BA, min_cosine);
      if (!best || inliers.size() > best->inliers.size()) best = {T_BA, std::move(inliers)};
    }
  }
  return best;
}

}  // namespace facet
