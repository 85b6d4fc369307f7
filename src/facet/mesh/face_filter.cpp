// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/face_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace facet {
namespace {

constexpr double kMinDepth_m = 0.05;

double Radians(double deg) {
  return deg * std::numbers::pi / 180;
}

struct Sides {
  double shortest2 = 0, middle2 = 0, longest2 = 0;  // squared [m^2]
};

Sides SidesOf(const std::array<Vector3d, 3>& p) {
  std::array<double, 3> s = {
      (p[1] - p[0]).squaredNorm(), (p[2] - p[1]).squaredNorm(), (p[0] - p[2]).squaredNorm()};
  std::sort(s.begin(), s.end());
  return {s[0], s[1], s[2]};
}

// The smallest angle lies opposite the shortest side (law of cosines).
bool IsNarrow(const Sides& s, const FaceLimits& limits) {
  if (s.shortest2 < limits.min_side_ratio * limits.min_side_ratio * s.longest2) return true;
  const double cosine =
      0.5 * (s.middle2 + s.longest2 - s.shortest2) / std::sqrt(s.middle2 * s.longest2);
  return !(cosine <= std::cos(Radians(limits.min_angle_deg)));
}

// Compares the extent across the view, with all vertices moved along their rays to the smallest
// depth, with the extent in depth that is not noise (Kimera's measure of elongation).
bool IsElongated(const CameraFace& face, const FaceLimits& limits) {
  const auto [near, far] =
      std::minmax({0, 1, 2}, [&](int i, int j) { return face.p_C[i].z() < face.p_C[j].z(); });
  const double z_min = face.p_C[near].z();
  const double noise = std::hypot(face.sigma_depth_m[near], face.sigma_depth_m[far]);
  const double depth = face.p_C[far].z() - z_min - limits.noise_sigmas * noise;
  if (depth <= 0) return false;
  std::array<Vector3d, 3> flat;
  for (int i = 0; i < 3; ++i)
    flat[i] = face.p_C[i] * (z_min / face.p_C[i].z());
  return std::sqrt(SidesOf(flat).longest2) < limits.min_elongation * depth;
}

bool IsGrazing(const CameraFace& face, const FaceLimits& limits) {
  const auto& [a, b, c] = face.p_C;
  const Vector3d n = (b - a).cross(c - a);
  const Vector3d centre = (a + b + c) / 3;
  return !(std::abs(n.dot(centre)) >=
           std::cos(Radians(limits.max_grazing_deg)) * n.norm() * centre.norm());
}

}  // namespace

FaceVerdict JudgeShape(const std::array<Vector3d, 3>& p, const FaceLimits& limits) {
  const Sides sides = SidesOf(p);
  if (!std::isfinite(sides.longest2)) return FaceVerdict::kNotFinite;
  if (sides.longest2 > limits.max_side_m * limits.max_side_m) return FaceVerdict::kTooLarge;
  if (!(sides.shortest2 > 0) || IsNarrow(sides, limits)) return FaceVerdict::kNarrow;
  return FaceVerdict::kAccepted;
}

FaceVerdict JudgeFace(const CameraFace& face, const FaceLimits& limits) {
  double z_min = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double z = face.p_C[i].z();
    if (!face.p_C[i].allFinite() || !(z >= kMinDepth_m)) return FaceVerdict::kNotFinite;
    if (!(face.sigma_depth_m[i] <= limits.max_depth_sigma * z)) return FaceVerdict::kUncertain;
    z_min = std::min(z_min, z);
  }
  const double longest2 = SidesOf(face.p_C).longest2;
  const double max_side = limits.max_side_per_depth * z_min;
  if (longest2 > max_side * max_side) return FaceVerdict::kTooLarge;
  const FaceVerdict shape = JudgeShape(face.p_C, limits);
  if (shape != FaceVerdict::kAccepted) return shape;
  if (IsElongated(face, limits)) return FaceVerdict::kElongated;
  if (IsGrazing(face, limits)) return FaceVerdict::kGrazing;
  return FaceVerdict::kAccepted;
}

}  // namespace facet
