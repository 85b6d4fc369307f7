// SPDX-License-Identifier: BSD-2-Clause
#include "facet/camera/plane_lens.h"

namespace facet {

namespace {

// A projection that divides by less has left the part of space that the model images.
constexpr double kMinDivisor = 1e-3;

// OpenCV, calib3d, "Detailed description".
struct Rational {
  double scale = 0;
  double bend = 0;  ///< (d scale / d r) / r
  bool is_seen = false;

  Rational(const CameraIntrinsics& k, double r2) {
    const auto& c = k.coefficients;
    const double above = 1 + r2 * (c[0] + r2 * (c[1] + r2 * c[4]));
    const double below = 1 + r2 * (c[5] + r2 * (c[6] + r2 * c[7]));
    if (!(below > kMinDivisor)) return;
    const double d_above = c[0] + r2 * (2 * c[1] + 3 * r2 * c[4]);  // by r2
    const double d_below = c[5] + r2 * (2 * c[6] + 3 * r2 * c[7]);
    scale = above / below;
    bend = 2 * (d_above * below - above * d_below) / (below * below);
    is_seen = true;
  }
};

// What p1 and p2 add.
Vector2d TangentialPart(const CameraIntrinsics& k, const Vector2d& xy, Matrix2d& J) {
  const double p1 = k.coefficients[2], p2 = k.coefficients[3];
  const double x = xy.x(), y = xy.y(), r2 = xy.squaredNorm(), off = 2 * (p1 * x + p2 * y);
  J << 2 * p1 * y + 6 * p2 * x, off, off, 6 * p1 * y + 2 * p2 * x;
  return {2 * p1 * x * y + p2 * (r2 + 2 * x * x), 2 * p2 * x * y + p1 * (r2 + 2 * y * y)};
}

}  // namespace

LensRadius RadiusThroughPlaneLens(const CameraIntrinsics& k, double r) {
  if (k.distortion == DistortionModel::kRadialTangential) return RadialTangentialRadius(k, r);
  if (k.distortion != DistortionModel::kRational) return {r, 1};
  const Rational s(k, r * r);
  if (!s.is_seen) return {0, 0};
  return {r * s.scale, s.scale + s.bend * r * r};
}

Vector2d DistortThroughPlaneLens(const CameraIntrinsics& k, const Vector2d& xy, Matrix2d* J) {
  if (k.distortion == DistortionModel::kRadialTangential) return DistortRadialTangential(k, xy, J);
  if (k.distortion != DistortionModel::kRational) {
    if (J) J->setIdentity();
    return xy;
  }
  const Rational s(k, xy.squaredNorm());
  Matrix2d more;
  const Vector2d tangential = TangentialPart(k, xy, more);
  if (J) *J = s.scale * Matrix2d::Identity() + s.bend * xy * xy.transpose() + more;
  return s.scale * xy + tangential;
}

Matrix<2, 4> PlaneLensCoefficientJacobian(const CameraIntrinsics& k, const Vector2d& xy) {
  if (k.distortion == DistortionModel::kRadialTangential) return RadialTangentialColumns(xy);
  Matrix<2, 4> J = Matrix<2, 4>::Zero();
  const double r2 = xy.squaredNorm();
  if (k.distortion != DistortionModel::kRational || !Rational(k, r2).is_seen) return J;
  const auto& c = k.coefficients;
  J = RadialTangentialColumns(xy);
  J.leftCols<2>() /= 1 + r2 * (c[5] + r2 * (c[6] + r2 * c[7]));
  return J;
}

}  // namespace facet
