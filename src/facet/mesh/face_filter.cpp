// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/face_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "facet/camera/camera_model.h"
#include "facet/mesh/far_surfaces.h"

namespace facet {
namespace {

double SquaredCosine(double deg) {
  const double cosine = std::cos(deg * std::numbers::pi / 180);
  return cosine * cosine;
}

}  // namespace

FaceFilter::FaceFilter(const FaceLimits& limits)
    : limits_(limits),
      cos2_min_angle_(SquaredCosine(limits.min_angle_deg)),
      cos2_max_grazing_(SquaredCosine(limits.max_grazing_deg)) {}

FaceFilter::Sides FaceFilter::SidesOf(const std::array<Vector3d, 3>& p) {
  const double a = (p[1] - p[0]).squaredNorm();
  const double b = (p[2] - p[1]).squaredNorm();
  const double c = (p[0] - p[2]).squaredNorm();
  const double low = std::min(a, b), high = std::max(a, b);
  return {std::min(low, c), std::max(low, std::min(high, c)), std::max(high, c)};
}

// The smallest angle lies opposite the shortest side (law of cosines) and is acute.
bool FaceFilter::IsNarrow(const Sides& s) const {
  if (s.shortest2 < limits_.min_side_ratio * limits_.min_side_ratio * s.longest2) return true;
  const double product = 0.5 * (s.middle2 + s.longest2 - s.shortest2);
  return !(product * product <= cos2_min_angle_ * s.middle2 * s.longest2);
}

// Compares the extent across the view, with all vertices moved along their rays to the smallest
// distance, with the extent in distance that is not noise (Kimera's measure of elongation).
bool FaceFilter::IsElongated(const CameraFace& face, const std::array<double, 3>& distance) const {
  const auto [near, far] =
      std::minmax({0, 1, 2}, [&](int i, int j) { return distance[i] < distance[j]; });
  const double extent = distance[far] - distance[near];
  const double noise2 = face.sigma_depth_m[near] * face.sigma_depth_m[near] +
                        face.sigma_depth_m[far] * face.sigma_depth_m[far];
  const double depth = extent - limits_.noise_sigmas * std::sqrt(noise2);
  if (depth <= 0) return false;
  std::array<Vector3d, 3> flat;
  for (int i = 0; i < 3; ++i)
    flat[i] = face.p_C[i] * (distance[near] / distance[i]);
  const double least = limits_.min_elongation * depth;
  return SidesOf(flat).longest2 < least * least;
}

bool FaceFilter::IsGrazing(const CameraFace& face) const {
  const auto& [a, b, c] = face.p_C;
  const Vector3d n = (b - a).cross(c - a), centre = a + b + c;
  const double product = n.dot(centre);
  return !(product * product >= cos2_max_grazing_ * n.squaredNorm() * centre.squaredNorm());
}

double FaceFilter::ScaleAt(double distance_m) const {
  return limits_.grow_with_distance ? LengthScale(distance_m) : 1;
}

FaceDefect FaceFilter::JudgeSides(const Sides& sides, double max_side_m) const {
  if (!std::isfinite(sides.longest2)) return FaceDefect::kNotFinite;
  if (sides.longest2 > max_side_m * max_side_m) return FaceDefect::kTooLarge;
  if (!(sides.shortest2 > 0) || IsNarrow(sides)) return FaceDefect::kNarrow;
  return FaceDefect::kNone;
}

FaceDefect FaceFilter::JudgeShape(const std::array<Vector3d, 3>& p) const {
  return JudgeSides(SidesOf(p), limits_.max_side_m);
}

FaceDefect FaceFilter::Judge(const CameraFace& face) const {
  std::array<double, 3> distance{};
  for (int i = 0; i < 3; ++i) {
    distance[i] = face.p_C[i].norm();
    if (!face.p_C[i].allFinite() || !(distance[i] >= kMinDistance_m)) return FaceDefect::kNotFinite;
    const double max_depth_sigma = ScaleAt(distance[i]) * limits_.max_depth_sigma;
    if (!(face.sigma_depth_m[i] <= max_depth_sigma * distance[i])) return FaceDefect::kUncertain;
  }
  const Sides sides = SidesOf(face.p_C);
  const double nearest = *std::min_element(distance.begin(), distance.end());
  const double max_side = limits_.max_side_per_depth * nearest;
  if (sides.longest2 > max_side * max_side) return FaceDefect::kTooLarge;
  const FaceDefect shape = JudgeSides(sides, ScaleAt(nearest) * limits_.max_side_m);
  if (shape != FaceDefect::kNone) return shape;
  if (IsElongated(face, distance)) return FaceDefect::kElongated;
  if (IsGrazing(face)) return FaceDefect::kGrazing;
  return FaceDefect::kNone;
}

}  // namespace facet
