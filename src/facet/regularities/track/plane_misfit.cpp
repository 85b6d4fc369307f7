// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/plane_misfit.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include "facet/geometry/so3.h"
#include "facet/regularities/detect/common_error.h"
#include "facet/regularities/detect/surface_face.h"
#include "facet/regularities/track/plane_gate.h"
#include "facet/regularities/track/surface_curvature.h"

namespace facet {

namespace {

constexpr std::size_t kMinLandmarks = 8;
// Landmarks stand out from their plane more than its surface does: prints, frames and panels are in
// front of walls.
constexpr double kLandmarkFlatness_m = 0.01;
constexpr double kMostUneven_m = 0.1;  // what is farther off is on something else
constexpr double kMaxSigmas = 2.5;     // a landmark that is farther off weighs as if it were here
// A plane is removed when it exceeds either limit in kMaxMisfits keyframes in a row.
constexpr double kMaxChiSquare = 12;  // 3 degrees of freedom
constexpr double kMaxScatterAtOnce = 2;
constexpr int kMaxMisfits = 3;
// Mean square of a plane's landmarks about it, over what is expected, on average over the last
// keyframes: more is a row of things, or two surfaces.
constexpr double kMaxScatter = 1.4;
constexpr int kMinJudged = 8;  // keyframes that a mean needs

double Square(double x) {
  return x * x;
}

// The landmarks of a plane as vision alone places them: the point-on-plane rows have pulled their
// estimates towards the plane, and that is undone here.
struct PlaneLandmarks {
  std::vector<Vector3d> points_W;
  std::vector<double> across_m;   // the plane
  std::vector<double> variances;  // of vision, across the plane [m^2]
  std::vector<double> weights;    // [1/m^2]
  std::vector<double> length_scales;
};

PlaneLandmarks LandmarksByVision(const MapSnapshot& map,
                                 const FaceCamera& camera,
                                 const TrackedPlane& tracked) {
  const Plane& plane = tracked.estimate.plane_W;
  PlaneLandmarks landmarks;
  for (const LandmarkEstimate& landmark : map.landmarks) {
    // The pulls of several planes cannot be told apart.
    if (landmark.planes[0] != tracked.id || landmark.planes[1].IsValid()) continue;
    const FacePoint point = MakeFacePoint(landmark.p_W, landmark.sigma_depth_m, camera);
    const double variance = point.VarianceAlong(plane.n);
    const double at_m = plane.SignedDistance(landmark.p_W);
    const double across_m =
        (1 + variance / Square(point.length_scale * tracked.estimate.row_sigma_m)) * at_m;
    const double expected = variance + Square(point.length_scale * kLandmarkFlatness_m);
    const double sigmas = std::abs(across_m) / std::sqrt(expected);
    landmarks.points_W.emplace_back(landmark.p_W + (across_m - at_m) * plane.n);
    landmarks.across_m.push_back(across_m);
    landmarks.variances.push_back(variance);
    landmarks.length_scales.push_back(point.length_scale);
    landmarks.weights.push_back(std::min(1.0, Square(kMaxSigmas / sigmas)) / expected);
  }
  return landmarks;
}

// How the landmarks of a plane lie.
struct LandmarkFit {
  double chi_square = 0;  // between this plane and the one that fits the landmarks best
  double scatter = 0;     // mean square about the latter, over what is expected
  std::optional<SurfaceCurvature> curvature;
  double excess = 0, excess_weight = 0;  // as in SurfaceUnevenness::Add
};

// Sums up by how much the landmarks are farther from the best plane, `fit` against the present one,
// than vision explains. Each weighs by how exactly its square says so.
void AddExcess(const PlaneLandmarks& landmarks,
               const Matrix<3, 2>& tangents,
               const Vector3d& centroid_W,
               const Vector3d& fit,
               LandmarkFit& out) {
  for (std::size_t i = 0; i < landmarks.points_W.size(); ++i) {
    const Vector2d along_m = tangents.transpose() * (landmarks.points_W[i] - centroid_W);
    const double off_m = landmarks.across_m[i] - fit.dot(Vector3d(1, along_m.x(), along_m.y()));
    const double variance = landmarks.variances[i];
    const double length_scale = landmarks.length_scales[i];
    const double weight = Square(1 / (variance + Square(length_scale * kLandmarkFlatness_m)));
    const double uneven_m = std::min(std::abs(off_m), length_scale * kMostUneven_m);
    out.excess += weight * (Square(uneven_m) - variance);
    out.excess_weight += weight;
  }
}

std::optional<LandmarkFit> FitLandmarks(const PlaneLandmarks& landmarks,
                                        const PlaneEstimate& plane,
                                        const FaceCamera& camera,
                                        const SE3& T_WB) {
  const std::size_t num = landmarks.points_W.size();
  if (num < kMinLandmarks) return std::nullopt;
  PlaneCandidate best;
  double total = 0;
  for (std::size_t i = 0; i < num; ++i) {
    best.centroid_W += landmarks.weights[i] * landmarks.points_W[i];
    total += landmarks.weights[i];
  }
  best.centroid_W /= total;
  const Vector3d& n = plane.plane_W.n;
  const Matrix<3, 2> B = TangentBasis(n);
  Matrix3d information = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  double square = 0;
  for (std::size_t i = 0; i < num; ++i) {
    const double weight = landmarks.weights[i], across_m = landmarks.across_m[i];
    const Vector2d along_m = B.transpose() * (landmarks.points_W[i] - best.centroid_W);
    const Vector3d row(1, along_m.x(), along_m.y());
    information += weight * row * row.transpose();
    b += weight * across_m * row;
    square += weight * Square(across_m);
  }
  const Eigen::LLT<Matrix3d> factor(information);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Vector3d fit = factor.solve(b);  // offset and slopes against the plane
  const Matrix3d covariance = factor.solve(Matrix3d::Identity());
  best.plane_W.n = (n - B * fit.tail<2>()).normalized();
  best.plane_W.d = best.plane_W.n.dot(best.centroid_W);
  const CommonError common = CommonErrorOf(best.plane_W, best.centroid_W, camera);
  best.normal_covariance =
      B * (covariance.bottomRightCorner<2, 2>() + Square(common.slope_rad) * Matrix2d::Identity()) *
      B.transpose();
  best.offset_variance_m2 = covariance(0, 0) + Square(common.offset_m);
  LandmarkFit out{ChiSquare(best, plane, T_WB),
                  (square - b.dot(fit)) / static_cast<double>(num),
                  FitCurvature(landmarks.points_W, landmarks.weights, n)};
  AddExcess(landmarks, B, best.centroid_W, fit, out);
  if (!std::isfinite(out.chi_square) || !std::isfinite(out.scatter)) return std::nullopt;
  return out;
}

bool IsMisfit(const MapSnapshot& map, const FaceCamera& camera, TrackedPlane& plane) {
  const std::optional<LandmarkFit> fit =
      FitLandmarks(LandmarksByVision(map, camera, plane), plane.estimate, camera, map.latest.T_WB);
  if (!fit) {
    plane.fit.num_misfits = 0;
    return false;
  }
  const bool misfits = fit->chi_square > kMaxChiSquare || fit->scatter > kMaxScatterAtOnce;
  plane.fit.num_misfits = misfits ? plane.fit.num_misfits + 1 : 0;
  plane.fit.scatter.Add(fit->scatter);
  plane.fit.unevenness.Add(fit->excess, fit->excess_weight);
  if (fit->curvature) plane.fit.curvature.Add(IsCurved(*fit->curvature));
  return plane.fit.num_misfits >= kMaxMisfits ||
         (plane.fit.scatter.num >= kMinJudged && plane.fit.scatter.mean > kMaxScatter);
}

}  // namespace

void RemoveMisfits(const MapSnapshot& map,
                   const FaceCamera& camera,
                   std::vector<TrackedPlane>& planes,
                   PlaneAssignments& out) {
  std::erase_if(planes, [&](TrackedPlane& plane) {
    if (plane.IsTentative() || !IsMisfit(map, camera, plane)) return false;
    for (const LandmarkEstimate& landmark : map.landmarks) {
      if (landmark.IsOn(plane.id)) out.detached.emplace_back(landmark.id, plane.id);
    }
    out.retired.push_back(plane.id);
    return true;
  });
  for (const TrackedPlane& plane : planes) {
    if (!plane.IsTentative()) out.unevenness.push_back({plane.id, plane.fit.unevenness.sigma_m()});
  }
}

}  // namespace facet
