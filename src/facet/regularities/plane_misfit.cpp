// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/plane_misfit.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include "facet/regularities/surface_face.h"

namespace facet {

namespace {

constexpr std::size_t kMinMembers = 8;
constexpr double kFlatness_m = 0.01;
constexpr double kMaxSigmas = 4;  // landmarks farther off count less
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

// A landmark of a plane where vision alone sees it: the row that holds it on the plane has drawn it
// towards it, and that is taken back.
struct Member {
  Vector2d along_m;     // the plane
  double across_m = 0;  // it
  double weight = 0;    // [1/m^2]
};

std::vector<Member> MembersAsSeen(const MapSnapshot& map, const KnownPlane& known) {
  const Plane& plane = known.estimate.plane_W;
  const Matrix<3, 2> B = TangentBasis(plane.n);
  std::vector<Member> members;
  for (const LandmarkEstimate& landmark : map.landmarks) {
    if (!landmark.IsOn(known.id)) continue;
    const FacePoint point = MakeFacePoint(landmark.p_W, landmark.sigma_depth_m, map.latest.T_WB.p);
    const double variance = point.VarianceAlong(plane.n);
    const double drawn = 1 + variance / Square(map.plane_sigma_m);
    const double across_m = drawn * plane.SignedDistance(landmark.p_W);
    const double expected = variance + Square(kFlatness_m);
    const double sigmas = std::abs(across_m) / std::sqrt(expected);
    members.push_back({B.transpose() * landmark.p_W,
                       across_m,
                       std::min(1.0, Square(kMaxSigmas / sigmas)) / expected});
  }
  return members;
}

// How the landmarks of a plane lie.
struct MembersFit {
  double chi_square = 0;  // of the plane that fits them best against this one
  double scatter = 0;     // mean square about that plane, over what is expected
};

std::optional<MembersFit> FitMembers(const std::vector<Member>& members) {
  if (members.size() < kMinMembers) return std::nullopt;
  Vector2d middle_m = Vector2d::Zero();
  double total = 0;
  for (const Member& member : members) {
    middle_m += member.weight * member.along_m;
    total += member.weight;
  }
  middle_m /= total;
  Matrix3d information = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  double square = 0;
  for (const Member& member : members) {
    const Vector2d r = member.along_m - middle_m;
    const Vector3d row(1, r.x(), r.y());
    information += member.weight * row * row.transpose();
    b += member.weight * member.across_m * row;
    square += member.weight * Square(member.across_m);
  }
  const Eigen::LLT<Matrix3d> factor(information);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Vector3d fit = factor.solve(b);  // offset and slopes against the plane
  Matrix3d covariance = factor.solve(Matrix3d::Identity());
  covariance.diagonal() += Vector3d(kSigmaOffset_m, kSigmaSlope, kSigmaSlope).cwiseAbs2();
  return MembersFit{fit.dot(covariance.llt().solve(fit)),
                    (square - b.dot(fit)) / static_cast<double>(members.size())};
}

bool IsMisfit(const MapSnapshot& map, double max_scatter, KnownPlane& known) {
  const std::optional<MembersFit> fit = FitMembers(MembersAsSeen(map, known));
  if (!fit) {
    known.num_misfits = 0;
    return false;
  }
  const bool misfits = fit->chi_square > kMaxChiSquare || fit->scatter > kMaxScatterAtOnce;
  known.num_misfits = misfits ? known.num_misfits + 1 : 0;
  known.scatter.Add(fit->scatter);
  return known.num_misfits >= kMaxMisfits ||
         (known.scatter.num >= kMinJudged && known.scatter.mean > max_scatter);
}

}  // namespace

void EndMisfits(const MapSnapshot& map,
                double max_scatter,
                std::vector<KnownPlane>& planes,
                PlaneAssignments& out) {
  std::erase_if(planes, [&](KnownPlane& plane) {
    if (plane.IsTentative() || !IsMisfit(map, max_scatter, plane)) return false;
    for (const LandmarkEstimate& landmark : map.landmarks) {
      if (landmark.IsOn(plane.id)) out.left.emplace_back(landmark.id, plane.id);
    }
    out.ended.push_back(plane.id);
    return true;
  });
}

}  // namespace facet
