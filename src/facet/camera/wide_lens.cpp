// SPDX-License-Identifier: BSD-2-Clause
#include "facet/camera/wide_lens.h"

#include <cmath>

namespace facet {

namespace {

// A projection that divides by less, per length of the direction, has left the part of space that
// the model images.
constexpr double kPi = 3.141592653589793;
constexpr double kMinDivisor = 1e-3;
// So near to the axis, as a tangent, quotients by the radius lose their digits.
constexpr double kAtAxis = 1e-4;

struct AxialScale {
  double scale = 0;
  double bend = 0;  ///< (d scale / d r) / r
  double by_z = 0;  ///< d scale / d z
  bool is_seen = false;
};

/// A direction as a lens that is round about its axis sees it.
struct AxialPoint {
  double r2, z, norm;

  explicit AxialPoint(const Vector3d& p)
      : r2(p.head<2>().squaredNorm()), z(p.z()), norm(p.norm()) {}
  bool IsAtAxis() const { return z > 0 && r2 < kAtAxis * kAtAxis * z * z; }
};

/// scale = 1 / divisor; `bend`: (d divisor / d r) / r.
AxialScale Divided(const AxialPoint& p, double divisor, double bend, double by_z) {
  if (!(divisor > kMinDivisor * p.norm)) return {};
  const double scale = 1 / divisor;
  return {scale, -scale * scale * bend, -scale * scale * by_z, true};
}

// Kannala and Brandt, "A generic camera model and calibration method", equation (6), divided by the
// first coefficient, which is the focal length.
LensRadius EquidistantRadius(const CameraIntrinsics& k, double theta) {
  const double t2 = theta * theta;
  const auto& c = k.coefficients;
  return {theta * (1 + t2 * (c[0] + t2 * (c[1] + t2 * (c[2] + t2 * c[3])))),
          1 + t2 * (3 * c[0] + t2 * (5 * c[1] + t2 * (7 * c[2] + 9 * t2 * c[3])))};
}

AxialScale EquidistantScale(const CameraIntrinsics& k, const AxialPoint& p) {
  const double n2 = p.norm * p.norm;
  if (p.IsAtAxis()) {
    const double bend = 2 * (k.coefficients[0] - 1.0 / 3.0) / (p.z * p.z * p.z);
    return {1 / p.z + 0.5 * bend * p.r2, bend, -1 / n2, true};
  }
  const double r = std::sqrt(p.r2);
  const LensRadius radius = EquidistantRadius(k, std::atan2(r, p.z));
  const double scale = radius.value / r;
  return {scale, (radius.slope * p.z / n2 - scale) / p.r2, -radius.slope / n2, true};
}

// Devernay and Faugeras, "Straight lines have to be straight", equation (13).
AxialScale FieldOfViewScale(double w, const AxialPoint& p) {
  const double t = 2 * std::tan(0.5 * w), q = p.z * p.z + t * t * p.r2;
  const double by_z = -t / (w * q);
  if (p.IsAtAxis()) {
    const double bend = -2.0 / 3.0 * t * t * t / (w * p.z * p.z * p.z);
    return {t / (w * p.z) + 0.5 * bend * p.r2, bend, by_z, true};
  }
  const double r = std::sqrt(p.r2), scale = std::atan2(t * r, p.z) / (w * r);
  return {scale, (t * p.z / (w * q) - scale) / p.r2, by_z, true};
}

// Usenko, Demmel and Cremers, "The double sphere camera model", equations (40) to (45).
struct DoubleSphere {
  double k, d2;

  DoubleSphere(double xi, const AxialPoint& p)
      : k(xi * p.norm + p.z), d2(std::sqrt(p.r2 + k * k)) {}
};

AxialScale DoubleSphereScale(double xi, double alpha, const AxialPoint& p) {
  const DoubleSphere s(xi, p);
  const double by_k = alpha * s.k / s.d2 + 1 - alpha;
  return Divided(p,
                 alpha * s.d2 + (1 - alpha) * s.k,
                 alpha / s.d2 + by_k * xi / p.norm,
                 by_k * (1 + xi * p.z / p.norm));
}

// Khomutenko, Garcia and Martinet, "An enhanced unified camera model", equation (10).
AxialScale ExtendedUnifiedScale(double alpha, double beta, const AxialPoint& p) {
  const double d = std::sqrt(beta * p.r2 + p.z * p.z);
  return Divided(p, alpha * d + (1 - alpha) * p.z, alpha * beta / d, alpha * p.z / d + 1 - alpha);
}

// Mei and Rives, "Single view point omnidirectional camera calibration from planar grids".
AxialScale UnifiedScale(double xi, const AxialPoint& p) {
  return Divided(p, p.z + xi * p.norm, xi / p.norm, 1 + xi * p.z / p.norm);
}

AxialScale ScaleOf(const CameraIntrinsics& k, const AxialPoint& p) {
  const auto& c = k.coefficients;
  const bool is_behind = !(p.r2 > 0) && !(p.z > 0);  // straight: it has no side
  if (!std::isfinite(p.norm) || is_behind) return {};
  switch (k.distortion) {
    case DistortionModel::kEquidistant:
      return EquidistantScale(k, p);
    case DistortionModel::kFieldOfView:
      return FieldOfViewScale(c[0], p);
    case DistortionModel::kDoubleSphere:
      return DoubleSphereScale(c[0], c[1], p);
    case DistortionModel::kExtendedUnified:
      return ExtendedUnifiedScale(c[0], c[1], p);
    case DistortionModel::kUnified:
      return UnifiedScale(c[4], p);
    case DistortionModel::kNone:
    case DistortionModel::kRadialTangential:
    case DistortionModel::kRational:
      break;
  }
  return {};
}

bool IsBetween(double value, double low, double high) {
  return value > low && value < high;
}

}  // namespace

std::optional<Vector2d> ProjectThroughWideLens(const CameraIntrinsics& k,
                                               const Vector3d& p,
                                               Matrix<2, 3>* J) {
  const AxialScale s = ScaleOf(k, AxialPoint(p));
  if (!s.is_seen) return std::nullopt;
  const Vector2d xy = p.head<2>(), m = s.scale * xy;
  if (J) {
    J->leftCols<2>() = s.scale * Matrix2d::Identity() + s.bend * xy * xy.transpose();
    J->col(2) = s.by_z * xy;
  }
  if (k.distortion != DistortionModel::kUnified) return m;
  Matrix2d behind;
  const Vector2d distorted = DistortRadialTangential(k, m, &behind);
  if (J) *J = behind * *J;
  return distorted;
}

LensRadius RadiusOfAngle(const CameraIntrinsics& k, double angle) {
  if (k.distortion == DistortionModel::kEquidistant) return EquidistantRadius(k, angle);
  const double r = std::sin(angle), z = std::cos(angle);
  const AxialScale s = ScaleOf(k, AxialPoint(Vector3d(r, 0, z)));
  if (!s.is_seen) return {0, 0};
  const LensRadius radius{r * s.scale, (s.scale + s.bend * r * r) * z - s.by_z * r * r};
  if (k.distortion != DistortionModel::kUnified) return radius;
  const LensRadius behind = RadialTangentialRadius(k, radius.value);
  return {behind.value, radius.slope * behind.slope};
}

Matrix<2, 4> WideLensCoefficientJacobian(const CameraIntrinsics& k, const Vector3d& p_C) {
  Matrix<2, 4> J = Matrix<2, 4>::Zero();
  const AxialPoint p(p_C);
  const AxialScale s = ScaleOf(k, p);
  if (!s.is_seen) return J;
  const auto& c = k.coefficients;
  const Vector2d xy = p_C.head<2>();
  const double by_divisor = -s.scale * s.scale;
  switch (k.distortion) {
    case DistortionModel::kEquidistant: {
      if (!(p.r2 > 0)) break;
      const double r = std::sqrt(p.r2), theta = std::atan2(r, p.z);
      double power = theta / r;
      for (int i = 0; i < 4; ++i) {
        power *= theta * theta;
        J.col(i) = power * xy;
      }
      break;
    }
    case DistortionModel::kFieldOfView: {
      const double w = c[0], half = std::tan(0.5 * w), t = 2 * half;
      const double by_t = p.z / (p.z * p.z + t * t * p.r2);
      J.col(0) = ((1 + half * half) * by_t - s.scale) / w * xy;
      break;
    }
    case DistortionModel::kDoubleSphere: {
      const DoubleSphere d(c[0], p);
      J.col(0) = by_divisor * p.norm * (c[1] * d.k / d.d2 + 1 - c[1]) * xy;
      J.col(1) = by_divisor * (d.d2 - d.k) * xy;
      break;
    }
    case DistortionModel::kExtendedUnified: {
      const double d = std::sqrt(c[1] * p.r2 + p.z * p.z);
      J.col(0) = by_divisor * (d - p.z) * xy;
      J.col(1) = by_divisor * (0.5 * c[0] * p.r2 / d) * xy;
      break;
    }
    case DistortionModel::kUnified:
      J = RadialTangentialColumns(s.scale * xy);
      break;
    case DistortionModel::kNone:
    case DistortionModel::kRadialTangential:
    case DistortionModel::kRational:
      break;
  }
  return J;
}

std::string WhatIsWrongWithWideLens(const CameraIntrinsics& k) {
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
    case DistortionModel::kEquidistant:
    case DistortionModel::kNone:
    case DistortionModel::kRadialTangential:
    case DistortionModel::kRational:
      break;
  }
  return {};
}

}  // namespace facet
