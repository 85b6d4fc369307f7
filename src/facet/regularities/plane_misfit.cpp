// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/plane_misfit.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include "facet/regularities/plane_gate.h"
#include "facet/regularities/surface_bend.h"
#include "facet/regularities/surface_face.h"

namespace facet {

namespace {

constexpr std::size_t kMinMembers = 8;
constexpr double kFlatness_m = 0.01;
constexpr double kMaxSigmas = 2.5;  // single landmarks farther off count as if they were there
// What poses and neighbouring landmarks have in common, 1-sigma.
constexpr double kSigmaOffset_m = 0.003, kSigmaSlope = 0.004;
// At once, in so many keyframes in a row.
constexpr double kMaxChiSquare = 12;  // 3 degrees of freedom
constexpr double kMaxScatterAtOnce = 2;
constexpr int kMaxMisfits = 3;
constexpr int kMinJudged = 8;  // keyframes, before what they say on average counts

double Square(double x) {
  return x * x;
}

// The landmarks of a plane where vision alone sees them: the rows that hold them on the plane have
// drawn them towards it, and that is taken back.
struct Members {
  std::vector<Vector3d> points_W;
  std::vector<double> across_m;  // the plane
  std::vector<double> weights;   // [1/m^2]
};

Members MembersAsSeen(const MapSnapshot& map, double sigma_direction, const KnownPlane& known) {
  const Plane& plane = known.estimate.plane_W;
  Members members;
  for (const LandmarkEstimate& landmark : map.landmarks) {
    // What several planes have drawn is not told apart.
    if (landmark.planes[0] != known.id || landmark.planes[1].IsValid()) continue;
    const FacePoint point =
        MakeFacePoint(landmark.p_W, landmark.sigma_depth_m, {map.latest.T_WB.p, sigma_direction});
    const double variance = point.VarianceAlong(plane.n);
    const double at_m = plane.SignedDistance(landmark.p_W);
    const double across_m = (1 + variance / Square(known.estimate.row_sigma_m)) * at_m;
    const double expected = variance + Square(kFlatness_m);
    const double sigmas = std::abs(across_m) / std::sqrt(expected);
    members.points_W.emplace_back(landmark.p_W + (across_m - at_m) * plane.n);
    members.across_m.push_back(across_m);
    members.weights.push_back(std::min(1.0, Square(kMaxSigmas / sigmas)) / expected);
  }
  return members;
}

// How the landmarks of a plane lie.
struct MembersFit {
  double chi_square = 0;  // of the plane that fits them best against this one
  double scatter = 0;     // mean square about that plane, over what is expected
  std::optional<SurfaceBend> bend;
};

std::optional<MembersFit> FitMembers(const Members& members,
                                     const PlaneEstimate& known,
                                     const SE3& T_WB) {
  const std::size_t num = members.points_W.size();
  if (num < kMinMembers) return std::nullopt;
  PlaneCandidate best;
  double total = 0;
  for (std::size_t i = 0; i < num; ++i) {
    best.centroid_W += members.weights[i] * members.points_W[i];
    total += members.weights[i];
  }
  best.centroid_W /= total;
  const Vector3d& n = known.plane_W.n;
  const Matrix<3, 2> B = TangentBasis(n);
  Matrix3d information = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  double square = 0;
  for (std::size_t i = 0; i < num; ++i) {
    const double weight = members.weights[i], across_m = members.across_m[i];
    const Vector2d along_m = B.transpose() * (members.points_W[i] - best.centroid_W);
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
  best.normal_covariance =
      B * (covariance.bottomRightCorner<2, 2>() + Square(kSigmaSlope) * Matrix2d::Identity()) *
      B.transpose();
  best.offset_variance_m2 = covariance(0, 0) + Square(kSigmaOffset_m);
  const MembersFit out{ChiSquare(best, known, T_WB),
                       (square - b.dot(fit)) / static_cast<double>(num),
                       FitBend(members.points_W, members.weights, n)};
  if (!std::isfinite(out.chi_square) || !std::isfinite(out.scatter)) return std::nullopt;
  return out;
}

bool IsMisfit(const MapSnapshot& map,
              double sigma_direction,
              const PlaneTrackingOptions& options,
              KnownPlane& known) {
  const std::optional<MembersFit> fit =
      FitMembers(MembersAsSeen(map, sigma_direction, known), known.estimate, map.latest.T_WB);
  if (!fit) {
    known.num_misfits = 0;
    return false;
  }
  const bool misfits = fit->chi_square > kMaxChiSquare || fit->scatter > kMaxScatterAtOnce;
  known.num_misfits = misfits ? known.num_misfits + 1 : 0;
  known.scatter.Add(fit->scatter);
  if (fit->bend) known.bends.Add(IsBent(*fit->bend, options.max_bend));
  return known.num_misfits >= kMaxMisfits ||
         (known.scatter.num >= kMinJudged && known.scatter.mean > options.max_scatter);
}

}  // namespace

void EndMisfits(const MapSnapshot& map,
                double sigma_direction,
                const PlaneTrackingOptions& options,
                std::vector<KnownPlane>& planes,
                PlaneAssignments& out) {
  std::erase_if(planes, [&](KnownPlane& plane) {
    if (plane.IsTentative() || !IsMisfit(map, sigma_direction, options, plane)) return false;
    for (const LandmarkEstimate& landmark : map.landmarks) {
      if (landmark.IsOn(plane.id)) out.left.emplace_back(landmark.id, plane.id);
    }
    out.ended.push_back(plane.id);
    return true;
  });
}

}  // namespace facet
