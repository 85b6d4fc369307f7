// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_membership.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace facet {

namespace {

// Of a landmark that is known to ten times the sigma of planes' landmarks.
constexpr double kMaxInnovationRatio = 10;

// 1-sigma of the landmark in the direction n_W, as vision knows it when the poses are given.
double SigmaAlong(const FrameGeometry& geometry,
                  WindowLandmark landmark,
                  const Vector3d& n_W,
                  const RobustOptions& robust) {
  landmark.planes = PlaneLinks();
  LandmarkBlock block;
  LinearizeLandmark(geometry, {}, landmark, robust, block);
  const FrameGeometry::Pose& host = geometry.frozen(landmark.host);
  const double distance = 1 / landmark.inverse_distance;
  const Vector3d n_H = host.R_WC0.transpose() * n_W;
  Vector3d J;
  J << distance * (TangentBasis(landmark.bearing_H).transpose() * n_H),
      -distance * distance * n_H.dot(landmark.bearing_H);
  const Eigen::LLT<Matrix3d> factor(block.V);
  if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return factor.matrixL().solve(J).norm();
}

bool MayJoin(const FrameGeometry& geometry,
             const SlidingWindow& window,
             const WindowPlane& plane,
             const WindowLandmark& landmark,
             const JoinLimits& limits,
             double max_distance_m,
             const RobustOptions& robust) {
  if (!landmark.has_depth || landmark.observations.empty() ||
      landmark.inverse_distance <= WindowLandmark::kMinPlaneInverseDistance) {
    return false;
  }
  const double sigma = SigmaAlong(geometry, landmark, plane.n, robust);
  if (!(sigma <= limits.max_sigma_m)) return false;
  const double error_m = plane.SignedDistance(window.PositionOf(landmark));
  return std::abs(error_m) <=
         std::max(
             {limits.max_distance_m, max_distance_m, 3 * std::hypot(sigma, robust.plane_sigma_m)});
}

}  // namespace

void ApplyAssignments(const PlaneAssignments& assignments,
                      const JoinLimits& limits,
                      const RobustOptions& robust,
                      const FrameGeometry& geometry,
                      SlidingWindow& window) {
  for (const NewPlane& created : assignments.created) {
    if (window.IndexOf(created.id) >= 0) continue;
    window.planes.emplace_back(created.id, created.plane_W, created.centroid_W);
  }
  for (const auto& [landmark_id, plane_id] : assignments.left) {
    WindowLandmark* landmark = window.Find(landmark_id);
    const int plane = window.IndexOf(plane_id);
    if (landmark != nullptr && plane >= 0) landmark->planes.Remove(plane);
  }
  for (const PlaneJoin& join : assignments.joined) {
    WindowLandmark* landmark = window.Find(join.landmark);
    const int plane = window.IndexOf(join.plane);
    if (landmark == nullptr || plane < 0 || landmark->planes.Contains(plane)) continue;
    const WindowPlane& known = window.planes[plane];
    if (MayJoin(geometry, window, known, *landmark, limits, join.max_distance_m, robust)) {
      landmark->planes.Add(plane);
    }
  }
  for (const PlaneRelation& relation : assignments.related)
    window.AddRelation(relation);
  for (const PlaneSighting& sighting : assignments.sighted) {
    if (window.IndexOf(sighting.plane) >= 0 && window.IndexOf(sighting.frame) >= 0)
      window.sightings.push_back(sighting);
  }
}

void ApplyProjections(const PlaneAssignments& assignments,
                      bool convert_back,
                      SlidingWindow& window) {
  const auto set = [&](const std::vector<LandmarkId>& ids, bool is_projection) {
    for (const LandmarkId id : ids) {
      if (WindowLandmark* landmark = window.Find(id)) landmark->is_projection = is_projection;
    }
  };
  if (convert_back) set(assignments.unprojected, false);
  set(assignments.projected, true);
}

int DetachOutliers(const FrameGeometry& geometry,
                   const RobustOptions& robust,
                   double max_sigma,
                   SlidingWindow& window) {
  int detached = 0;
  for (WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.IsOnPlanes()) continue;
    for (int k = landmark.planes.count - 1; k >= 0; --k) {
      const int plane = landmark.planes.index[static_cast<std::size_t>(k)];
      const WindowPlane& known = window.planes[plane];
      const double at_m = std::abs(known.SignedDistance(window.PositionOf(landmark)));
      if (at_m / robust.plane_sigma_m * kMaxInnovationRatio <= max_sigma) continue;
      // The row itself has drawn the landmark to the plane. Vision alone would place it farther
      // off by this ratio.
      const double sigma = SigmaAlong(geometry, landmark, known.n, robust);
      const double ratio = 1 + sigma * sigma / (known.row_sigma_m * known.row_sigma_m);
      if (at_m * ratio <= max_sigma * std::hypot(sigma, robust.plane_sigma_m)) continue;
      landmark.planes.Remove(plane);
      ++detached;
    }
  }
  return detached;
}

std::vector<int> CountMembers(const SlidingWindow& window) {
  std::vector<int> members(window.planes.size(), 0);
  for (const WindowLandmark& landmark : window.landmarks()) {
    for (int k = 0; landmark.IsOnPlanes() && k < landmark.planes.count; ++k)
      ++members[static_cast<std::size_t>(landmark.planes.index[static_cast<std::size_t>(k)])];
  }
  return members;
}

void WeighPlanes(const RobustOptions& robust, SlidingWindow& window) {
  const std::vector<int> members = CountMembers(window);
  for (std::size_t k = 0; k < members.size(); ++k) {
    window.planes[k].row_sigma_m =
        std::hypot(robust.plane_sigma_m, std::sqrt(members[k]) * robust.plane_common_sigma_m);
  }
}

namespace {

// Mean squared distance of each plane's landmarks from its anchor; infinite for a plane without.
std::vector<double> SquaredExtents(const SlidingWindow& window) {
  std::vector<double> extents(window.planes.size(), 0.0);
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.IsOnPlanes()) continue;
    const Vector3d p_W = window.PositionOf(landmark);
    for (int k = 0; k < landmark.planes.count; ++k) {
      const auto plane =
          static_cast<std::size_t>(landmark.planes.index[static_cast<std::size_t>(k)]);
      extents[plane] += (p_W - window.planes[plane].anchor_W).squaredNorm();
    }
  }
  const std::vector<int> members = CountMembers(window);
  for (std::size_t k = 0; k < extents.size(); ++k)
    extents[k] = members[k] > 0 ? extents[k] / members[k] : std::numeric_limits<double>::infinity();
  return extents;
}

}  // namespace

void MarkSettledPlanes(const std::vector<Matrix3d>& information,
                       const SettledLimits& limits,
                       SlidingWindow& window) {
  const auto square = [](double x) { return x * x; };
  const std::vector<double> extents = SquaredExtents(window);
  for (std::size_t k = 0; k < window.planes.size(); ++k) {
    const Eigen::LLT<Matrix3d> factor(information[k]);
    if (factor.info() != Eigen::Success) continue;
    const Matrix3d covariance = factor.solve(Matrix3d::Identity());
    const double variance_normal = covariance(0, 0) + covariance(1, 1);
    const bool has_normal = variance_normal < square(limits.sigma_normal_rad) ||
                            variance_normal * extents[k] < square(limits.sigma_rim_m);
    if (has_normal && covariance(2, 2) < square(limits.sigma_offset_m))
      window.planes[k].settled = true;
  }
}

void CutUnsettledLinks(const std::vector<char>& leaving_landmarks, SlidingWindow& window) {
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    if (leaving_landmarks[l] == 0) continue;
    PlaneLinks& links = window.landmarks()[l].planes;
    for (int k = links.count - 1; k >= 0; --k) {
      const int plane = links.index[static_cast<std::size_t>(k)];
      if (!window.planes[plane].settled) links.Remove(plane);
    }
  }
}

namespace {

bool AreAtTheSamePlace(const SE3& a, const SE3& b) {
  constexpr double kMaxDistance_m = 0.1, kMaxAngle_rad = 0.09;
  return (a.p - b.p).norm() < kMaxDistance_m && a.q.angularDistance(b.q) < kMaxAngle_rad;
}

}  // namespace

void CutSightings(const std::vector<char>& leaving_frames, SlidingWindow& window) {
  const auto frame_of = [&](const PlaneSighting& s) { return window.IndexOf(s.frame); };
  const auto leaves = [&](const PlaneSighting& s) {
    return leaving_frames[static_cast<std::size_t>(frame_of(s))] != 0;
  };
  const auto pose_of = [&](const PlaneSighting& s) -> const SE3& {
    return window.frames[frame_of(s)].x.T_WB;
  };
  std::vector<PlaneSighting> staying = window.sightings;
  std::erase_if(staying, leaves);
  std::erase_if(window.sightings, [&](const PlaneSighting& sighting) {
    if (!leaves(sighting)) return false;
    if (!window.planes[window.IndexOf(sighting.plane)].settled) return true;
    return std::any_of(staying.begin(), staying.end(), [&](const PlaneSighting& other) {
      return other.plane == sighting.plane && AreAtTheSamePlace(pose_of(other), pose_of(sighting));
    });
  });
}

void CutUnsettledRelations(const std::vector<char>& leaving_planes, SlidingWindow& window) {
  const auto is_unsettled = [&](PlaneId id) {
    const int plane = window.IndexOf(id);
    const WindowPlane& p = window.planes[plane];
    return leaving_planes[static_cast<std::size_t>(plane)] == 0 && !p.settled && !p.frozen;
  };
  const auto leaves = [&](PlaneId id) {
    return leaving_planes[static_cast<std::size_t>(window.IndexOf(id))] != 0;
  };
  std::erase_if(window.relations, [&](const WindowRelation& w) {
    const PlaneRelation& r = w.relation;
    if (r.IsUnary()) return false;
    return (leaves(r.a) && is_unsettled(r.b)) || (leaves(r.b) && is_unsettled(r.a));
  });
}

void RemoveUnsupportedPlanes(int min_landmarks, SlidingWindow& window) {
  const std::vector<int> members = CountMembers(window);
  const auto is_sighted = [&](PlaneId id) {
    return std::any_of(window.sightings.begin(), window.sightings.end(), [&](const auto& sighting) {
      return sighting.plane == id;
    });
  };
  for (int k = static_cast<int>(window.planes.size()) - 1; k >= 0; --k) {
    const WindowPlane& plane = window.planes[k];
    const int needed = is_sighted(plane.id) ? 1 : min_landmarks;
    if (!plane.frozen && members[k] < needed) window.RemovePlane(k);
  }
}

}  // namespace facet
