// SPDX-License-Identifier: BSD-2-Clause
#include "facet/camera/lens_models.h"

#include <cmath>

namespace facet {

namespace {

constexpr double kPi = 3.141592653589793;
// A projection that divides by less has left the part of space that the model images.
constexpr double kMinDivisor = 1e-3;

/// A radially symmetric lens sees the point xy at scale * xy.
struct RadialScale {
  double scale = 1;
  double bend = 0;  ///< (d scale / d r) / r
  bool is_seen = true;
};

/// scale = 1 / divisor; `bend`: (d divisor / d r) / r.
RadialScale Divided(double divisor, double bend) {
  if (!(divisor > kMinDivisor)) return {0, 0, false};
  return {1 / divisor, -bend / (divisor * divisor), true};
}

// Devernay and Faugeras, "Straight lines have to be straight", equation (13).
RadialScale FieldOfViewScale(double w, double r2) {
  const double t = 2 * std::tan(0.5 * w);
  const double u2 = t * t * r2;
  if (u2 < 1e-8) return {t / w * (1 - u2 / 3), -2.0 / 3.0 * t * t * t / w, true};
  const double u = std::sqrt(u2), angle = std::atan(u);
  const double scale = t / w * angle / u;
  return {scale, t / w * (1 / (1 + u2) - angle / u) / r2, true};
}

// Usenko, Demmel and Cremers, "The double sphere camera model", equations (40) to (45).
struct DoubleSphere {
  double d1, k, d2, divisor;

  DoubleSphere(double xi, double alpha, double r2)
      : d1(std::sqrt(1 + r2)),
        k(xi * d1 + 1),
        d2(std::sqrt(r2 + k * k)),
        divisor(alpha * d2 + (1 - alpha) * k) {}
};

RadialScale DoubleSphereScale(double xi, double alpha, double r2) {
  const DoubleSphere s(xi, alpha, r2);
  return Divided(s.divisor, alpha * (1 + s.k * xi / s.d1) / s.d2 + (1 - alpha) * xi / s.d1);
}

// Khomutenko, Garcia and Martinet, "An enhanced unified camera model", equation (10).
RadialScale ExtendedUnifiedScale(double alpha, double beta, double r2) {
  const double d = std::sqrt(beta * r2 + 1);
  return Divided(alpha * d + 1 - alpha, alpha * beta / d);
}

// Mei and Rives, "Single view point omnidirectional camera calibration from planar grids".
RadialScale UnifiedScale(double xi, double r2) {
  const double d = std::sqrt(1 + r2);
  return Divided(1 + xi * d, xi / d);
}

// OpenCV, calib3d, "Detailed description".
RadialScale RationalScale(const CameraIntrinsics& k, double r2) {
  const auto& c = k.coefficients;
  const double above = 1 + r2 * (c[0] + r2 * (c[1] + r2 * c[4]));
  const double below = 1 + r2 * (c[5] + r2 * (c[6] + r2 * c[7]));
  if (!(below > kMinDivisor)) return {0, 0, false};
  const double d_above = c[0] + r2 * (2 * c[1] + 3 * r2 * c[4]);  // by r2
  const double d_below = c[5] + r2 * (2 * c[6] + 3 * r2 * c[7]);
  return {above / below, 2 * (d_above * below - above * d_below) / (below * below), true};
}

RadialScale ScaleOf(const CameraIntrinsics& k, double r2) {
  const auto& c = k.coefficients;
  switch (k.distortion) {
    case DistortionModel::kRational:
      return RationalScale(k, r2);
    case DistortionModel::kFieldOfView:
      return FieldOfViewScale(c[0], r2);
    case DistortionModel::kDoubleSphere:
      return DoubleSphereScale(c[0], c[1], r2);
    case DistortionModel::kExtendedUnified:
      return ExtendedUnifiedScale(c[0], c[1], r2);
    case DistortionModel::kUnified:
      return UnifiedScale(c[4], r2);
    case DistortionModel::kNone:
    case DistortionModel::kRadialTangential:
    case DistortionModel::kEquidistant:
      break;
  }
  return {};
}

// What p1 and p2 add.
Vector2d TangentialPart(const CameraIntrinsics& k, const Vector2d& xy, Matrix2d& J) {
  const double p1 = k.coefficients[2], p2 = k.coefficients[3];
  const double x = xy.x(), y = xy.y(), r2 = xy.squaredNorm(), off = 2 * (p1 * x + p2 * y);
  J << 2 * p1 * y + 6 * p2 * x, off, off, 6 * p1 * y + 2 * p2 * x;
  return {2 * p1 * x * y + p2 * (r2 + 2 * x * x), 2 * p2 * x * y + p1 * (r2 + 2 * y * y)};
}

bool IsBetween(double value, double low, double high) {
  return value > low && value < high;
}

}  // namespace

bool IsWideLens(DistortionModel model) {
  return model == DistortionModel::kFieldOfView || model == DistortionModel::kDoubleSphere ||
         model == DistortionModel::kExtendedUnified || model == DistortionModel::kUnified;
}

LensRadius RadiusThroughLens(const CameraIntrinsics& k, double r) {
  const RadialScale s = ScaleOf(k, r * r);
  if (!s.is_seen) return {0, 0};
  const LensRadius radius{r * s.scale, s.scale + s.bend * r * r};
  if (k.distortion != DistortionModel::kUnified) return radius;
  const LensRadius behind = RadialTangentialRadius(k, radius.value);
  return {behind.value, radius.slope * behind.slope};
}

Vector2d DistortThroughLens(const CameraIntrinsics& k, const Vector2d& xy, Matrix2d* J) {
  const RadialScale s = ScaleOf(k, xy.squaredNorm());
  const Vector2d m = s.scale * xy;
  if (J) *J = s.scale * Matrix2d::Identity() + s.bend * xy * xy.transpose();
  Matrix2d more;
  if (k.distortion == DistortionModel::kRational) {
    const Vector2d tangential = TangentialPart(k, xy, more);
    if (J) *J += more;
    return m + tangential;
  }
  if (k.distortion != DistortionModel::kUnified) return m;
  const Vector2d behind = DistortRadialTangential(k, m, &more);
  if (J) *J = more * *J;
  return behind;
}

Matrix<2, 4> LensCoefficientJacobian(const CameraIntrinsics& k, const Vector2d& xy) {
  Matrix<2, 4> J = Matrix<2, 4>::Zero();
  const auto& c = k.coefficients;
  const double r2 = xy.squaredNorm();
  const RadialScale s = ScaleOf(k, r2);
  if (!s.is_seen) return J;
  const double by_divisor = -s.scale * s.scale;
  switch (k.distortion) {
    case DistortionModel::kRational: {
      J = RadialTangentialColumns(xy);
      J.leftCols<2>() /= 1 + r2 * (c[5] + r2 * (c[6] + r2 * c[7]));
      break;
    }
    case DistortionModel::kFieldOfView: {
      const double w = c[0], half = std::tan(0.5 * w), d_half = 0.5 * (1 + half * half);
      J.col(0) = (-s.scale / w + 2 * d_half / (w * (1 + 4 * half * half * r2))) * xy;
      break;
    }
    case DistortionModel::kDoubleSphere: {
      const DoubleSphere d(c[0], c[1], r2);
      J.col(0) = by_divisor * (c[1] * d.k * d.d1 / d.d2 + (1 - c[1]) * d.d1) * xy;
      J.col(1) = by_divisor * (d.d2 - d.k) * xy;
      break;
    }
    case DistortionModel::kExtendedUnified: {
      const double d = std::sqrt(c[1] * r2 + 1);
      J.col(0) = by_divisor * (d - 1) * xy;
      J.col(1) = by_divisor * (0.5 * c[0] * r2 / d) * xy;
      break;
    }
    case DistortionModel::kUnified:
      J = RadialTangentialColumns(s.scale * xy);
      break;
    case DistortionModel::kNone:
    case DistortionModel::kRadialTangential:
    case DistortionModel::kEquidistant:
      break;
  }
  return J;
}

std::string WhatIsWrongWithLens(const CameraIntrinsics& k) {
  const auto& c = k.coefficients;
  switch (k.distortion) {
    case DistortionModel::kFieldOfView:
      if (!IsBetween(c[0], 1e-3, kPi)) return "the field of view w must be between 0 and pi";
      break;
    case DistortionModel::kDoubleSphere:
      if (!IsBetween(c[0], -0.99, 10)) return "xi of a double sphere must be above -1";
      if (!IsBetween(c[1], -1e-9, 1)) return "alpha of a double sphere must be from 0 to 1";
      break;
    case DistortionModel::kExtendedUnified:
      if (!IsBetween(c[0], -1e-9, 1))
        return "alpha of an extended unified camera must be from 0 to 1";
      if (!IsBetween(c[1], 0, 100)) return "beta of an extended unified camera must be above 0";
      break;
    case DistortionModel::kUnified:
      if (!IsBetween(c[4], -0.99, 100)) return "xi of a unified camera must be above -1";
      break;
    case DistortionModel::kNone:
    case DistortionModel::kRadialTangential:
    case DistortionModel::kEquidistant:
    case DistortionModel::kRational:
      break;
  }
  return {};
}

}  // namespace facet
