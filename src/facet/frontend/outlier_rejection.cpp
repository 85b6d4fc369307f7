// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/outlier_rejection.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

// A ray so close to the epipole that it does not define a plane.
constexpr double kMinSine = 1e-3;
// How wrong the given rotation may be [rad], 1-sigma.
constexpr double kRotationSigma = 0.05;
// A model that explains this share of the pairs needs no better one.
constexpr double kGoodRatio = 0.9;
// One that explains less is not trusted: nothing is removed.
constexpr double kMinInlierRatio = 0.7;
// Two of two pairs are inliers with a probability of 0.49 or more: 60 samples miss in 1 of 10^17.
constexpr int kMaxIterations = 60;
// Median motion apart from the rotation, below which directions of translation would be noise.
constexpr double kMinParallax_px = 1.0;

// Distance of the turned second ray from the epipolar plane [rad].
double PlaneAngle(const Vector3d& before, const Vector3d& now, const Vector3d& t) {
  const Vector3d normal = t.cross(before);
  const double length = normal.norm();
  if (length < kMinSine) return (now - before).norm();
  return std::abs(normal.dot(now)) / length;
}

// Positive when the parallax has the sign of a point in front of both cameras.
double InFront(const Vector3d& before, const Vector3d& now, const Vector3d& t) {
  return before.cross(now).dot(t.cross(before));
}

}  // namespace

int OutlierRejection::CountInliers(std::span<const BearingPair> pairs, const Model& model) const {
  return static_cast<int>(std::count_if(pairs.begin(), pairs.end(), [&](const BearingPair& pair) {
    return PlaneAngle(pair.before, model.turn * pair.now, model.t) < max_angle_;
  }));
}

double OutlierRejection::MedianParallaxPx(std::span<const BearingPair> pairs,
                                          const Quaterniond& turn) {
  parallax_px_.clear();
  for (const BearingPair& pair : pairs) {
    parallax_px_.push_back((turn * pair.now - pair.before).norm() * focal_px_);
  }
  const auto middle = parallax_px_.begin() + static_cast<std::ptrdiff_t>(parallax_px_.size() / 2);
  std::nth_element(parallax_px_.begin(), middle, parallax_px_.end());
  return *middle;
}

Quaterniond OutlierRejection::AlignBearings(std::span<const BearingPair> pairs) const {
  Quaterniond turn = Quaterniond::Identity();
  for (int i = 0; i < 5; ++i) {
    Matrix3d H = 1e-9 * Matrix3d::Identity();
    Vector3d b = Vector3d::Zero();
    for (const BearingPair& pair : pairs) {
      const Vector3d now = turn * pair.now;
      const Vector3d r = now - pair.before;
      const double weight = 1 / (1 + r.squaredNorm() / (9 * max_angle_ * max_angle_));
      const Matrix3d J = -Hat(now);  // d r / d turn, on the left
      H += weight * J.transpose() * J;
      b -= weight * J.transpose() * r;
    }
    turn = (ExpSO3(H.ldlt().solve(b)) * turn).normalized();
  }
  return turn;
}

OutlierRejection::Model OutlierRejection::SampleTranslation(std::span<const BearingPair> pairs,
                                                            const Quaterniond& turn) const {
  constexpr std::uint64_t kSeed = 7;
  Rng rng(kSeed);
  const int n = static_cast<int>(pairs.size());
  Model best;
  best.turn = turn;
  for (int i = 0; i < kMaxIterations; ++i) {
    const BearingPair& a = pairs[static_cast<std::size_t>(rng.Index(n))];
    const BearingPair& b = pairs[static_cast<std::size_t>(rng.Index(n))];
    const Vector3d t = a.before.cross(turn * a.now).cross(b.before.cross(turn * b.now));
    const double length = t.norm();
    if (!(length > 1e-12)) continue;
    Model model;
    model.turn = turn;
    model.t = t / length;
    model.num_inliers = CountInliers(pairs, model);
    if (model.num_inliers > best.num_inliers) best = model;
    if (best.num_inliers > kGoodRatio * n) break;
  }
  return best;
}

void OutlierRejection::Refine(std::span<const BearingPair> pairs, Model& model) const {
  for (int i = 0; i < 6; ++i) {
    const Matrix<3, 2> basis = TangentBasis(model.t);
    Matrix<5, 5> H = Matrix<5, 5>::Zero();
    const double prior = max_angle_ * max_angle_ / (kRotationSigma * kRotationSigma);
    H.topLeftCorner<3, 3>().diagonal().setConstant(prior);
    H.bottomRightCorner<2, 2>().diagonal().setConstant(1e-6);
    Vector<5> b = Vector<5>::Zero();
    b.head<3>() = -prior * LogSO3(model.turn);
    for (const BearingPair& pair : pairs) {
      const Vector3d now = model.turn * pair.now;
      const Vector3d normal = model.t.cross(pair.before);
      const double length = normal.norm();
      if (length < kMinSine) continue;
      const double r = normal.dot(now) / length;
      Vector<5> J;
      J << now.cross(normal), basis.transpose() * pair.before.cross(now);
      J /= length;
      const double weight = 1 / (1 + r * r / (max_angle_ * max_angle_));
      H += weight * J * J.transpose();
      b -= weight * r * J;
    }
    const Vector<5> d = H.ldlt().solve(b);
    model.turn = (ExpSO3(d.head<3>()) * model.turn).normalized();
    model.t = (model.t + basis * d.tail<2>()).normalized();
  }
  model.num_inliers = CountInliers(pairs, model);
}

OutlierVerdict OutlierRejection::Find(std::span<const BearingPair> pairs,
                                      std::vector<unsigned char>& is_outlier) {
  constexpr std::size_t kMinPairs = 10;
  is_outlier.assign(pairs.size(), 0);
  if (pairs.size() < kMinPairs) return OutlierVerdict::kFewPoints;
  const Quaterniond aligned = AlignBearings(pairs);
  if (MedianParallaxPx(pairs, aligned) < kMinParallax_px) {
    return OutlierVerdict::kLowParallax;
  }
  // The given rotation, and one that takes all common motion for rotation; both are then refined.
  Model best;
  for (const Quaterniond& turn : {Quaterniond::Identity(), aligned}) {
    Model model = SampleTranslation(pairs, turn);
    Model refined = model;
    Refine(pairs, refined);
    if (refined.num_inliers >= model.num_inliers) model = refined;
    if (model.num_inliers > best.num_inliers) best = model;
    if (best.num_inliers > kGoodRatio * static_cast<double>(pairs.size())) break;
  }
  if (best.num_inliers < kMinInlierRatio * static_cast<double>(pairs.size())) {
    return OutlierVerdict::kNoModel;
  }
  int front = 0;
  for (const BearingPair& pair : pairs) {
    front += InFront(pair.before, best.turn * pair.now, best.t) > 0 ? 1 : -1;
  }
  if (front < 0) best.t = -best.t;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Vector3d now = best.turn * pairs[i].now;
    const bool off_plane = PlaneAngle(pairs[i].before, now, best.t) >= max_angle_;
    // Behind the cameras by more than the noise: a false match along the epipolar line.
    const bool behind = InFront(pairs[i].before, now, best.t) < 0 &&
                        (now - pairs[i].before).norm() > 3 * max_angle_;
    is_outlier[i] = off_plane || behind ? 1 : 0;
  }
  return OutlierVerdict::kTrusted;
}

}  // namespace facet
