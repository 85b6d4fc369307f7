// SPDX-License-Identifier: BSD-2-Clause
#include "facet/camera/camera_model.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "facet/base/check.h"
#include "facet/camera/plane_lens.h"
#include "facet/camera/radial_tangential.h"
#include "facet/camera/wide_lens.h"
#include "facet/geometry/angles.h"

namespace facet {

namespace {

constexpr double kMaxRadius = 11.430052302761343;  // tan(85 deg)
constexpr double kMaxAngle = 110 * kDegree;

// The field of view ends where the image radius grows slower than this with the undistorted radius
// (or angle): zero is the fold; just before it, pixel noise is blown up without bound.
constexpr double kMinSlope = 0.02;

constexpr int kMaxIterations = 50;
constexpr double kConverged = 1e-12;  // in directions, about 5e-10 px
constexpr double kMaxError = 1e-10;   // on the plane of unit focal length

/// Distorted radius and its slope. The argument is the angle from the axis for lenses that are
/// described by directions, otherwise the radius on the plane z = 1.
LensRadius RadialDistortion(const CameraIntrinsics& k, double argument) {
  return IsWideLens(k.distortion) ? RadiusOfAngle(k, argument)
                                  : RadiusThroughPlaneLens(k, argument);
}

/// Whether the radial distortion grows everywhere, where that is easily seen: its slope is a
/// parabola over the squared radius.
bool AlwaysGrows(const CameraIntrinsics& k) {
  if (k.distortion != DistortionModel::kRadialTangential) return false;
  const double k1 = k.coefficients[0], k2 = k.coefficients[1];
  const double lowest_r2 = k2 > 0 ? std::max(0.0, -0.3 * k1 / k2) : 0;
  if (lowest_r2 > kMaxRadius * kMaxRadius) return false;
  constexpr double kRounding = 1e-6;
  const auto grows_at = [&](double r) {
    return RadialDistortion(k, r).slope > kMinSlope + kRounding;
  };
  return grows_at(0) && grows_at(std::sqrt(lowest_r2)) && grows_at(kMaxRadius);
}

/// Largest argument up to which the radial distortion grows (or where lenses end).
double FindMaxArgument(const CameraIntrinsics& k) {
  constexpr int kSteps = 4000;
  const double end = IsWideLens(k.distortion) ? kMaxAngle : kMaxRadius;
  if (AlwaysGrows(k)) return end;
  for (int i = 1; i <= kSteps; ++i) {
    double high = end * i / kSteps;
    if (RadialDistortion(k, high).slope > kMinSlope) continue;
    double low = end * (i - 1) / kSteps;
    while (high - low > 1e-12) {
      const double middle = 0.5 * (low + high);
      (RadialDistortion(k, middle).slope > kMinSlope ? low : high) = middle;
    }
    return low;
  }
  return end;
}

/// DistortThroughPlaneLens, with the most common lens inline: every projection goes through it.
Vector2d Distort(const CameraIntrinsics& k, const Vector2d& xy, Matrix2d* J) {
  return k.distortion == DistortionModel::kRadialTangential ? DistortRadialTangential(k, xy, J)
                                                            : DistortThroughPlaneLens(k, xy, J);
}

/// Inverse of RadialDistortion, which grows up to max_argument, so that Newton's method with a
/// bracket always finds it; empty if it is not inside.
std::optional<double> ArgumentOf(const CameraIntrinsics& k, double radius, double max_argument) {
  double low = 0, high = max_argument;
  if (RadialDistortion(k, high).value < radius) return std::nullopt;
  double argument = std::min(radius, 0.5 * high);
  for (int i = 0; i < kMaxIterations; ++i) {
    const LensRadius f = RadialDistortion(k, argument);
    (f.value < radius ? low : high) = argument;
    double next = argument - (f.value - radius) / f.slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const bool converged = std::abs(next - argument) < kConverged;
    argument = next;
    if (converged) break;
  }
  return argument;
}

/// Without the tangential part: the point of the plane z = 1 that is seen at xy_d.
std::optional<Vector2d> UndistortRadially(const CameraIntrinsics& k,
                                          const Vector2d& xy_d,
                                          double max_radius) {
  const double r_d = xy_d.norm();
  if (r_d < 1e-9) return xy_d;
  const std::optional<double> r = ArgumentOf(k, r_d, max_radius);
  if (!r) return std::nullopt;
  return Vector2d(xy_d * (*r / r_d));
}

/// A point of the plane z = 1 and how its image moves with it.
struct PlanePoint {
  Vector2d xy;
  Matrix2d J;  // d distorted / d xy
};

/// The point that is seen at xy_d, by Newton's method from `start`; empty if that leaves the image
/// or takes more steps. The last step is so small that the next one would be rounding.
std::optional<PlanePoint> Undistort(const CameraIntrinsics& k,
                                    const Vector2d& xy_d,
                                    const Vector2d& start,
                                    int max_steps) {
  constexpr double kLastStep = 1e-10;  // its square is what is left
  PlanePoint point{start, {}};
  for (int i = 0; i < max_steps; ++i) {
    const Vector2d error = Distort(k, point.xy, &point.J) - xy_d;
    if (!(point.J.determinant() > 0)) return std::nullopt;
    const Vector2d step = point.J.inverse() * error;
    point.xy -= step;
    if (step.norm() < kLastStep * (1 + point.xy.norm())) return point;
  }
  return std::nullopt;
}

/// UndistortRadially as a unit vector, for lenses that are described by directions.
std::optional<Vector3d> BearingRadially(const CameraIntrinsics& k,
                                        const Vector2d& xy_d,
                                        double max_angle) {
  const double r_d = xy_d.norm();
  if (r_d < 1e-9) return Vector3d(xy_d.x(), xy_d.y(), 1).normalized();
  const std::optional<double> angle = ArgumentOf(k, r_d, max_angle);
  if (!angle) return std::nullopt;
  const Vector2d xy = xy_d * (std::sin(*angle) / r_d);
  return Vector3d(xy.x(), xy.y(), std::cos(*angle));
}

/// How a direction is turned into a pixel keeps left and right apart: the image is not mirrored.
bool IsUpright(const Matrix<2, 3>& J, const Vector3d& bearing) {
  return Vector3d(J.row(0)).cross(Vector3d(J.row(1))).dot(bearing) > 0;
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
/// `max_argument`: of RadialDistortion.
std::string WhatIsWrongAt(const CameraIntrinsics& k, const Vector2d& px, double max_argument) {
  // No lens does more: magnify as much, or be as skew.
  constexpr double kMostMagnified = 5;
  constexpr double kMostSkew = 0.25;  // of the image
  const bool is_wide = IsWideLens(k.distortion);
  const Vector2d xy_d((px.x() - k.cx) / k.fx, (px.y() - k.cy) / k.fy);
  const std::optional<double> argument = ArgumentOf(k, xy_d.norm(), max_argument);
  std::ostringstream text;
  if (!argument) {
    text << "the distortion is singular inside the image: it folds over at "
         << (is_wide ? max_argument : std::atan(max_argument)) / kDegree << " deg from the axis";
    return text.str();
  }
  const double radius = is_wide ? std::tan(std::min(*argument, std::atan(kMaxRadius))) : *argument;
  if (!(kMostMagnified * radius >= xy_d.norm())) {
    text << "no lens distorts so much: half way to the border the image would be magnified more "
            "than "
         << kMostMagnified << " times";
    return text.str();
  }
  const Vector2d there =
      is_wide ? ProjectThroughWideLens(k, *BearingRadially(k, xy_d, max_argument), nullptr)
                    .value_or(xy_d)
              : Distort(k, *UndistortRadially(k, xy_d, max_argument), nullptr);
  const Vector2d px_off = (there - xy_d).cwiseProduct(Vector2d(k.fx, k.fy));
  if (px_off.norm() <= kMostSkew * std::max(k.width, k.height)) return {};
  text << "no lens is so skew: the last two coefficients move a point half way to the border by "
       << px_off.norm() << " px";
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
  } else if (text << WhatIsWrongWithWideLens(k); text.str().empty()) {
    // Half way from the principal point to each side every camera must see something.
    const double max_argument = FindMaxArgument(k);
    for (const Vector2d& side : {Vector2d(0, k.cy),
                                 Vector2d(k.width, k.cy),
                                 Vector2d(k.cx, 0),
                                 Vector2d(k.cx, k.height)}) {
      text << WhatIsWrongAt(k, 0.5 * (Vector2d(k.cx, k.cy) + side), max_argument);
      if (!text.str().empty()) break;
    }
  }
  return text.str();
}

CameraModel::CameraModel(const CameraIntrinsics& k) : k_(k) {
  const std::string problem = WhatIsWrong(k);
  FACET_CHECK(problem.empty()) << problem;
  const double max_argument = FindMaxArgument(k);
  const bool is_wide = IsWideLens(k.distortion);
  max_radius_ = is_wide ? 0 : max_argument;
  max_seen_radius_ = RadialDistortion(k, max_argument).value;
  max_angle_ = is_wide ? max_argument : std::atan(max_argument);
  min_cosine_ = std::cos(max_angle_);
  mean_focal_px_ = 0.5 * (k.fx + k.fy) * RadialDistortion(k, 0).slope;
}

std::optional<Vector2d> CameraModel::ProjectWidely(const Vector3d& p_C, Matrix<2, 3>* J) const {
  if (!(p_C.z() >= min_cosine_ * p_C.norm())) return std::nullopt;
  const std::optional<Vector2d> xy_d = ProjectThroughWideLens(k_, p_C, J);
  if (!xy_d) return std::nullopt;
  if (J) *J = Vector2d(k_.fx, k_.fy).asDiagonal() * *J;
  return Vector2d(k_.fx * xy_d->x() + k_.cx, k_.fy * xy_d->y() + k_.cy);
}

std::optional<Vector2d> CameraModel::Project(const Vector3d& p_C, Matrix<2, 3>* J) const {
  if (IsWideLens(k_.distortion)) return ProjectWidely(p_C, J);
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

// Newton's method takes the tangential part in; without one it starts at the solution.
std::optional<PixelBearing> CameraModel::WideBearingOf(const Vector2d& xy_d) const {
  const std::optional<Vector3d> start = BearingRadially(k_, xy_d, max_angle_);
  if (!start) return std::nullopt;
  PixelBearing ray{*start, {}};
  bool converged = false;
  for (int i = 0; i < kMaxIterations; ++i) {
    const auto there = ProjectThroughWideLens(k_, ray.bearing, &ray.J_px_bearing);
    if (!there || !IsUpright(ray.J_px_bearing, ray.bearing)) return std::nullopt;
    const Vector2d error = *there - xy_d;
    if (converged) {
      if (error.norm() > kMaxError || !(ray.bearing.z() >= min_cosine_)) return std::nullopt;
      ray.J_px_bearing = Vector2d(k_.fx, k_.fy).asDiagonal() * ray.J_px_bearing;
      return ray;
    }
    const Vector3d step = AcrossRay(ray.J_px_bearing) * error;
    ray.bearing = (ray.bearing - step).normalized();
    converged = step.norm() < kConverged;
  }
  return std::nullopt;
}

// From where the pixel is seen Newton's method needs three or four steps, unless the lens bends so
// much that it must start where the radial part alone would have the point.
std::optional<PixelBearing> CameraModel::BearingOf(const Vector2d& px) const {
  const Vector2d xy_d((px.x() - k_.cx) / k_.fx, (px.y() - k_.cy) / k_.fy);
  if (!xy_d.allFinite()) return std::nullopt;
  if (IsWideLens(k_.distortion)) return WideBearingOf(xy_d);
  if (!(xy_d.squaredNorm() <= max_seen_radius_ * max_seen_radius_)) return std::nullopt;
  constexpr int kFewSteps = 6;
  std::optional<PlanePoint> point = Undistort(k_, xy_d, xy_d, kFewSteps);
  const auto is_in_view = [this](const std::optional<PlanePoint>& p) {
    return p && p->xy.norm() <= max_radius_;
  };
  if (!is_in_view(point)) {
    const std::optional<Vector2d> start = UndistortRadially(k_, xy_d, max_radius_);
    if (start) point = Undistort(k_, xy_d, *start, kMaxIterations);
  }
  if (!is_in_view(point)) return std::nullopt;
  PixelBearing ray;
  ray.bearing = point->xy.homogeneous().normalized();
  ray.J_px_bearing.leftCols<2>() = Vector2d(k_.fx, k_.fy).asDiagonal() * point->J / ray.bearing.z();
  ray.J_px_bearing.col(2) = -ray.J_px_bearing.leftCols<2>() * point->xy;
  return ray;
}

std::optional<Vector3d> CameraModel::Unproject(const Vector2d& px) const {
  const std::optional<PixelBearing> ray = BearingOf(px);
  if (!ray) return std::nullopt;
  return ray->bearing;
}

}  // namespace facet
