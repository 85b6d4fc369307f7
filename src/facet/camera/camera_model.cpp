// SPDX-License-Identifier: BSD-2-Clause
#include "facet/camera/camera_model.h"

#include <algorithm>
#include <sstream>

#include <Eigen/LU>

#include "facet/base/check.h"
#include "facet/camera/lens_models.h"
#include "facet/camera/radial_tangential.h"

namespace facet {

namespace {

constexpr double kMaxRadius = 11.430052302761343;  // tan(85 deg)

// The field of view ends where the image radius grows slower than this with the undistorted radius
// (or angle): zero is the fold; just before it, pixel noise is blown up without bound.
constexpr double kMinSlope = 0.02;

constexpr int kMaxIterations = 50;
constexpr double kConverged = 1e-12;  // on the plane z = 1, about 5e-10 px

/// Distorted radius of an undistorted one, for the radial part of the model; the slope is by the
/// argument.
using Radial = LensRadius;

// Argument: angle from the axis.
Radial EquidistantRadius(const CameraIntrinsics& k, double theta) {
  const double t2 = theta * theta;
  const auto& c = k.coefficients;
  return {theta * (1 + t2 * (c[0] + t2 * (c[1] + t2 * (c[2] + t2 * c[3])))),
          1 + t2 * (3 * c[0] + t2 * (5 * c[1] + t2 * (7 * c[2] + 9 * t2 * c[3])))};
}

Radial RadialDistortion(const CameraIntrinsics& k, double argument) {
  switch (k.distortion) {
    case DistortionModel::kRadialTangential:
      return RadialTangentialRadius(k, argument);
    case DistortionModel::kEquidistant:
      return EquidistantRadius(k, argument);
    default:
      break;
  }
  if (!IsWideLens(k.distortion)) return RadiusThroughLens(k, argument);
  const double r = std::tan(argument);
  const Radial radius = RadiusThroughLens(k, r);
  return {radius.value, radius.slope * (1 + r * r)};
}

// The argument of RadialDistortion that belongs to a radius on the plane z = 1, and back.
bool IsByAngle(const CameraIntrinsics& k) {
  return k.distortion == DistortionModel::kEquidistant || IsWideLens(k.distortion);
}
double ArgumentOfRadius(const CameraIntrinsics& k, double r) {
  return IsByAngle(k) ? std::atan(r) : r;
}
double RadiusOfArgument(const CameraIntrinsics& k, double argument) {
  return IsByAngle(k) ? std::tan(argument) : argument;
}

/// Largest |xy| on the plane z = 1 up to which the radial distortion grows (or 85 deg).
double FindMaxRadius(const CameraIntrinsics& k) {
  constexpr int kSteps = 4000;
  const double end = ArgumentOfRadius(k, kMaxRadius);
  for (int i = 1; i <= kSteps; ++i) {
    double high = end * i / kSteps;
    if (RadialDistortion(k, high).slope > kMinSlope) continue;
    double low = end * (i - 1) / kSteps;
    while (high - low > 1e-12) {
      const double middle = 0.5 * (low + high);
      (RadialDistortion(k, middle).slope > kMinSlope ? low : high) = middle;
    }
    return RadiusOfArgument(k, low);
  }
  return kMaxRadius;
}

Vector2d DistortEquidistant(const CameraIntrinsics& k, const Vector2d& xy, Matrix2d* J) {
  const double r = xy.norm();
  // xy_d = scale xy, with scale = theta_d(atan r) / r; `bend` is (d scale / d r) / r.
  double scale, bend;
  if (r < 1e-4) {
    bend = 2 * (k.coefficients[0] - 1.0 / 3.0);
    scale = 1 + 0.5 * bend * r * r;
  } else {
    const Radial theta_d = EquidistantRadius(k, std::atan(r));
    scale = theta_d.value / r;
    bend = (theta_d.slope / (1 + r * r) - scale) / (r * r);
  }
  if (J) *J = scale * Matrix2d::Identity() + bend * xy * xy.transpose();
  return scale * xy;
}

/// From the ideal to the distorted point on the plane z = 1. J: d result / d xy.
Vector2d Distort(const CameraIntrinsics& k, const Vector2d& xy, Matrix2d* J) {
  switch (k.distortion) {
    case DistortionModel::kRadialTangential:
      return DistortRadialTangential(k, xy, J);
    case DistortionModel::kEquidistant:
      return DistortEquidistant(k, xy, J);
    default:
      return DistortThroughLens(k, xy, J);
  }
}

/// Inverse of the radial part: the undistorted point in the direction of xy_d. RadialDistortion
/// grows on [0, max_radius], so Newton's method with a bracket always finds it; empty if it is not
/// inside.
std::optional<Vector2d> UndistortRadially(const CameraIntrinsics& k,
                                          const Vector2d& xy_d,
                                          double max_radius) {
  const double r_d = xy_d.norm();
  if (r_d < 1e-9) return xy_d;
  double low = 0, high = ArgumentOfRadius(k, max_radius);
  if (RadialDistortion(k, high).value < r_d) return std::nullopt;
  double argument = std::min(r_d, 0.5 * high);
  for (int i = 0; i < kMaxIterations; ++i) {
    const Radial f = RadialDistortion(k, argument);
    (f.value < r_d ? low : high) = argument;
    double next = argument - (f.value - r_d) / f.slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const bool converged = std::abs(next - argument) < kConverged;
    argument = next;
    if (converged) break;
  }
  return Vector2d(xy_d * (RadiusOfArgument(k, argument) / r_d));
}

bool AllFinite(const CameraIntrinsics& k) {
  const bool pinhole =
      std::isfinite(k.fx) && std::isfinite(k.fy) && std::isfinite(k.cx) && std::isfinite(k.cy);
  return pinhole && std::all_of(k.coefficients.begin(), k.coefficients.end(), [](double c) {
           return std::isfinite(c);
         });
}

/// Whether a coordinate of the principal point is one of an image of this side. Lenses sit before
/// the middle of their sensor. Cropped images may have it anywhere, but a border that comes to lie
/// at the axis would be chance, and nobody crops away the middle; values that were left out,
/// normalised or measured otherwise are all there or beyond.
bool IsInTheImage(double c, int side) {
  constexpr double kBorder = 0.02;
  return c >= kBorder * side && c <= (1 - kBorder) * side;
}

/// What is wrong with the distortion at a point that every camera must see; empty: nothing.
std::string WhatIsWrongAt(const CameraIntrinsics& k, const Vector2d& px, double max_radius) {
  // No lens does more: magnify as much, or be as skew.
  constexpr double kMostMagnified = 5;
  constexpr double kMostSkew = 0.25;  // of the image
  const Vector2d xy_d((px.x() - k.cx) / k.fx, (px.y() - k.cy) / k.fy);
  const std::optional<Vector2d> xy = UndistortRadially(k, xy_d, max_radius);
  std::ostringstream text;
  if (!xy) {
    text << "the distortion is singular inside the image: it folds over at "
         << std::atan(max_radius) * 57.29577951308232 << " deg from the axis";
  } else if (!(kMostMagnified * xy->norm() >= xy_d.norm())) {
    text << "no lens distorts so much: half way to the border the image would be magnified more "
            "than "
         << kMostMagnified << " times";
  } else {
    const Vector2d tangential = Distort(k, *xy, nullptr) - xy_d;
    const Vector2d px_off = tangential.cwiseProduct(Vector2d(k.fx, k.fy));
    if (px_off.norm() <= kMostSkew * std::max(k.width, k.height)) return {};
    text << "no lens is so skew: the last two coefficients move a point half way to the border by "
         << px_off.norm() << " px";
  }
  return text.str();
}

}  // namespace

std::string CameraModel::WhatIsWrong(const CameraIntrinsics& k) {
  constexpr int kMaxSize = 1 << 16;
  std::ostringstream text;
  if (k.width <= 0 || k.height <= 0 || k.width > kMaxSize || k.height > kMaxSize) {
    text << "image size " << k.width << " x " << k.height << " is not usable";
  } else if (!AllFinite(k)) {
    text << "a parameter is not a finite number";
  } else if (k.fx <= 0 || k.fy <= 0) {
    text << "focal length " << k.fx << ", " << k.fy << " px is not positive";
  } else if (k.fx < 0.05 * k.width || k.fx > 50.0 * k.width || k.fy < 0.05 * k.height ||
             k.fy > 50.0 * k.height) {
    text << "focal length " << k.fx << ", " << k.fy << " px does not fit an image of " << k.width
         << " x " << k.height;
  } else if (!IsInTheImage(k.cx, k.width) || !IsInTheImage(k.cy, k.height)) {
    text << "principal point " << k.cx << ", " << k.cy << " px is outside the image of " << k.width
         << " x " << k.height
         << ", or at its border: it is a place in the recorded image, near the middle, in pixels "
            "(not in shares of the image or in millimetres); was the image cropped or scaled after "
            "the calibration?";
  } else if (text << WhatIsWrongWithLens(k); text.str().empty()) {
    // Half way from the principal point to each side every camera must see something.
    const double max_radius = FindMaxRadius(k);
    for (const Vector2d& side : {Vector2d(0, k.cy),
                                 Vector2d(k.width, k.cy),
                                 Vector2d(k.cx, 0),
                                 Vector2d(k.cx, k.height)}) {
      text << WhatIsWrongAt(k, 0.5 * (Vector2d(k.cx, k.cy) + side), max_radius);
      if (!text.str().empty()) break;
    }
  }
  return text.str();
}

CameraModel::CameraModel(const CameraIntrinsics& k) : k_(k) {
  const std::string problem = WhatIsWrong(k);
  FACET_CHECK(problem.empty()) << problem;
  max_radius_ = FindMaxRadius(k);
  mean_focal_px_ = 0.5 * (k.fx + k.fy) * RadialDistortion(k, 0).slope;
}

std::optional<Vector2d> CameraModel::Project(const Vector3d& p_C, Matrix<2, 3>* J) const {
  if (!(p_C.z() > 0)) return std::nullopt;
  const Vector2d xy = p_C.head<2>() / p_C.z();
  if (!(xy.squaredNorm() <= max_radius_ * max_radius_)) return std::nullopt;
  Matrix2d J_distort;
  const Vector2d xy_d = Distort(k_, xy, J ? &J_distort : nullptr);
  if (J) {
    J->leftCols<2>() = Vector2d(k_.fx, k_.fy).asDiagonal() * J_distort / p_C.z();
    J->col(2) = -J->leftCols<2>() * xy;
  }
  return Vector2d(k_.fx * xy_d.x() + k_.cx, k_.fy * xy_d.y() + k_.cy);
}

std::optional<UndistortedPoint> CameraModel::Undistort(const Vector2d& px) const {
  const Vector2d xy_d((px.x() - k_.cx) / k_.fx, (px.y() - k_.cy) / k_.fy);
  if (!xy_d.allFinite()) return std::nullopt;
  const std::optional<Vector2d> start = UndistortRadially(k_, xy_d, max_radius_);
  if (!start) return std::nullopt;

  // Newton's method takes the tangential part in; without one it starts at the solution.
  Vector2d xy = *start;
  Matrix2d J;
  bool converged = false;
  for (int i = 0; i < kMaxIterations && !converged; ++i) {
    const Vector2d error = Distort(k_, xy, &J) - xy_d;
    if (!(J.determinant() > 0)) return std::nullopt;
    const Vector2d step = J.inverse() * error;
    xy -= step;
    converged = step.norm() < kConverged * (1 + xy.norm());
  }
  if (!converged || !(xy.norm() <= max_radius_)) return std::nullopt;
  if ((Distort(k_, xy, &J) - xy_d).norm() > 1e-10 || !(J.determinant() > 0)) return std::nullopt;
  return UndistortedPoint{xy, J.inverse() * Vector2d(1 / k_.fx, 1 / k_.fy).asDiagonal()};
}

std::optional<PixelBearing> CameraModel::BearingOf(const Vector2d& px) const {
  const std::optional<UndistortedPoint> point = Undistort(px);
  if (!point) return std::nullopt;
  PixelBearing ray;
  ray.bearing = point->xy.homogeneous().normalized();
  ray.J_px_bearing.leftCols<2>() = point->J_xy_px.inverse() / ray.bearing.z();
  ray.J_px_bearing.col(2) = -ray.J_px_bearing.leftCols<2>() * point->xy;
  return ray;
}

std::optional<Vector3d> CameraModel::Unproject(const Vector2d& px) const {
  const std::optional<UndistortedPoint> point = Undistort(px);
  if (!point) return std::nullopt;
  return point->xy.homogeneous().normalized();
}

}  // namespace facet
