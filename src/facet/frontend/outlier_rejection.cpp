// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/outlier_rejection.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace facet {
namespace {

// Distance of the second ray from the epipolar plane [rad], and whether the parallax has the sign of a
// point in front of both cameras. With translation t of the camera, before x now is along -(t x before).
double PlaneAngle(const BearingPair& pair, const Vector3d& t) {
  const Vector3d normal = t.cross(pair.before);
  const double length = normal.norm();
  // A point at the epipole: its motion is small in every direction, compare the bearings themselves.
  if (length < 1e-3) return (pair.now - pair.before).norm();
  return std::abs(normal.dot(pair.now)) / length;
}

// Sum of signs of the parallax: positive when most of the points lie in front for translation t.
double InFront(const BearingPair& pair, const Vector3d& t) {
  return pair.before.cross(pair.now).dot(pair.before.cross(-t));
}

}  // namespace

int OutlierRejection::CountInliers(std::span<const BearingPair> pairs,
                                   const Vector3d& direction) const {
  const double max_angle = options_.max_error_px / focal_px_;
  return static_cast<int>(std::count_if(pairs.begin(), pairs.end(), [&](const BearingPair& pair) {
    return PlaneAngle(pair, direction) < max_angle;
  }));
}

Vector3d OutlierRejection::Refine(std::span<const BearingPair> pairs,
                                  const Vector3d& direction) const {
  // The normals before x now have the length of the parallax: far points weigh little, as they should.
  const double max_angle = options_.max_error_px / focal_px_;
  Matrix3d M = Matrix3d::Zero();
  for (const BearingPair& pair : pairs) {
    if (PlaneAngle(pair, direction) >= max_angle) continue;
    const Vector3d normal = pair.before.cross(pair.now);
    M += normal * normal.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(M);
  return solver.eigenvectors().col(0);
}

OutlierVerdict OutlierRejection::Find(std::span<const BearingPair> pairs,
                                      std::vector<unsigned char>& is_outlier) {
  constexpr std::size_t kMinPairs = 10;
  constexpr std::uint64_t kSeed = 7;
  is_outlier.assign(pairs.size(), 0);
  if (pairs.size() < kMinPairs) return OutlierVerdict::kFewPoints;
  parallax_px_.clear();
  for (const BearingPair& pair : pairs) {
    parallax_px_.push_back((pair.now - pair.before).norm() * focal_px_);
  }
  const auto middle = parallax_px_.begin() + static_cast<std::ptrdiff_t>(parallax_px_.size() / 2);
  std::nth_element(parallax_px_.begin(), middle, parallax_px_.end());
  if (*middle < options_.min_parallax_px) return OutlierVerdict::kLowParallax;

  Rng rng(kSeed);
  const int n = static_cast<int>(pairs.size());
  Vector3d best = Vector3d::UnitX();
  int best_count = 0;
  for (int i = 0; i < options_.max_iterations; ++i) {
    const BearingPair& a = pairs[static_cast<std::size_t>(rng.Index(n))];
    const BearingPair& b = pairs[static_cast<std::size_t>(rng.Index(n))];
    const Vector3d t = a.before.cross(a.now).cross(b.before.cross(b.now));
    const double length = t.norm();
    if (!(length > 1e-12)) continue;
    const int count = CountInliers(pairs, t / length);
    if (count <= best_count) continue;
    best_count = count;
    best = t / length;
  }
  const Vector3d refined = Refine(pairs, best);
  if (CountInliers(pairs, refined) >= best_count) best = refined;
  best_count = CountInliers(pairs, best);
  if (best_count < options_.min_inlier_ratio * n) return OutlierVerdict::kNoModel;

  double front = 0;
  for (const BearingPair& pair : pairs) front += InFront(pair, best) > 0 ? 1 : -1;
  if (front < 0) best = -best;
  const double max_angle = options_.max_error_px / focal_px_;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const bool off_plane = PlaneAngle(pairs[i], best) >= max_angle;
    // Behind the camera by more than the noise: a false match along the epipolar line.
    const bool behind = InFront(pairs[i], best) < 0 &&
                        (pairs[i].now - pairs[i].before).norm() > 2 * max_angle;
    is_outlier[i] = off_plane || behind ? 1 : 0;
  }
  return OutlierVerdict::kTrusted;
}

}  // namespace facet
