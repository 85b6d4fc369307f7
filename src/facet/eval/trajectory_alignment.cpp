// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/trajectory_alignment.h"

#include <cmath>

#include <Eigen/SVD>

#include "facet/base/check.h"

namespace facet {

namespace {

Vector3d Mean(std::span<const Vector3d> points) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : points) {
    sum += p;
  }
  return sum / static_cast<double>(points.size());
}

// What both kinds of rotation are computed from.
struct Moments {
  Vector3d p_mean_W, p_mean_G;
  Matrix3d cross = Matrix3d::Zero();  // sum (p_G - p_mean_G) (p_W - p_mean_W)^T
  double square_sum = 0;              // sum |p_W - p_mean_W|^2
};

Moments ComputeMoments(std::span<const Vector3d> p_W, std::span<const Vector3d> p_G) {
  Moments m{Mean(p_W), Mean(p_G)};
  for (std::size_t i = 0; i < p_W.size(); ++i) {
    const Vector3d w = p_W[i] - m.p_mean_W;
    m.cross += (p_G[i] - m.p_mean_G) * w.transpose();
    m.square_sum += w.squaredNorm();
  }
  return m;
}

// Umeyama's equation (40): the rotation that maximises trace(R^T cross).
Matrix3d BestRotation(const Matrix3d& cross) {
  const Eigen::JacobiSVD<Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d sign = Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

Matrix3d BestRotationAboutZ(const Matrix3d& cross) {
  const double yaw = std::atan2(cross(1, 0) - cross(0, 1), cross(0, 0) + cross(1, 1));
  return Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace

std::optional<AlignmentKind> AlignmentKindFromText(std::string_view text) {
  for (AlignmentKind kind : {AlignmentKind::kSE3, AlignmentKind::kYawOnly, AlignmentKind::kSim3}) {
    if (text == ToString(kind)) return kind;
  }
  return std::nullopt;
}

const char* ToString(AlignmentKind kind) {
  switch (kind) {
    case AlignmentKind::kSE3:
      return "se3";
    case AlignmentKind::kYawOnly:
      return "yaw";
    case AlignmentKind::kSim3:
      return "sim3";
  }
  return "";
}

TrajectoryAlignment AlignTrajectory(std::span<const Vector3d> p_W,
                                    std::span<const Vector3d> p_G,
                                    AlignmentKind kind) {
  FACET_CHECK(!p_W.empty() && p_W.size() == p_G.size())
      << p_W.size() << " and " << p_G.size() << " points";
  const Moments m = ComputeMoments(p_W, p_G);
  const Matrix3d R_GW =
      kind == AlignmentKind::kYawOnly ? BestRotationAboutZ(m.cross) : BestRotation(m.cross);
  TrajectoryAlignment alignment;
  if (kind == AlignmentKind::kSim3 && m.square_sum > 0) {
    alignment.scale = (R_GW.transpose() * m.cross).trace() / m.square_sum;  // Umeyama (42)
  }
  alignment.T_GW.q = Quaterniond(R_GW).normalized();
  alignment.T_GW.p = m.p_mean_G - alignment.T_GW.q * (alignment.scale * m.p_mean_W);
  return alignment;
}

}  // namespace facet
