// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_membership.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "facet/estimator/factors/landmark_factors.h"

namespace facet {

namespace {

// Of a landmark that is known to ten times the sigma of planes' landmarks.
constexpr double kMaxInnovationRatio = 10;

// 1-sigma of the landmark in the direction n_W, as vision knows it when the poses are given.
double SigmaAlong(const FrameGeometry& geometry,
                  WindowLandmark landmark,
                  const Vector3d& n_W,
                  const FactorNoise& noise) {
  landmark.planes = PlaneLinks();
  LandmarkBlock block;
  LinearizeLandmark(geometry, {}, landmark, noise, block);
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

void JoinLandmarks(const std::vector<PlaneJoin>& joins,
                   const PlaneOptions& options,
                   const FactorNoise& noise,
                   const FrameGeometry& geometry,
                   SlidingWindow& window) {
  for (const PlaneJoin& join : joins) {
    WindowLandmark* landmark = window.Find(join.landmark);
    const int index = window.IndexOf(join.plane);
    if (landmark == nullptr || index < 0 || landmark->planes.Contains(index)) continue;
    if (!landmark->has_depth || landmark->observations.empty() ||
        landmark->inverse_distance <= WindowLandmark::kMinPlaneInverseDistance) {
      continue;
    }
    const WindowPlane& plane = window.planes[index];
    const double sigma_m = SigmaAlong(geometry, *landmark, plane.n, noise);
    if (!(sigma_m <= options.join_sigma_m)) continue;
    const double distance_m = std::abs(plane.SignedDistance(window.PositionOf(*landmark)));
    const double max_distance_m = std::max({options.join_distance_m,
                                            join.max_distance_m,
                                            3 * std::hypot(sigma_m, noise.plane_sigma_m)});
    if (distance_m <= max_distance_m) landmark->planes.Add(index);
  }
}

}  // namespace

void ApplyAssignments(const PlaneAssignments& assignments,
                      const PlaneOptions& options,
                      const FactorNoise& noise,
                      const FrameGeometry& geometry,
                      SlidingWindow& window) {
  for (const NewPlane& created : assignments.created) {
    if (window.IndexOf(created.id) >= 0) continue;
    window.planes.emplace_back(
        created.id, created.plane_W, created.centroid_W, noise.plane_sigma_m);
  }
  for (const auto& [landmark_id, plane_id] : assignments.left) {
    WindowLandmark* landmark = window.Find(landmark_id);
    const int plane = window.IndexOf(plane_id);
    if (landmark != nullptr && plane >= 0) landmark->planes.Remove(plane);
  }
  JoinLandmarks(assignments.joined, options, noise, geometry, window);
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
                   const FactorNoise& noise,
                   double max_sigma,
                   SlidingWindow& window) {
  int detached = 0;
  for (WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.IsOnPlanes()) continue;
    for (int k = landmark.planes.count() - 1; k >= 0; --k) {
      const int plane = landmark.planes[k];
      const WindowPlane& known = window.planes[plane];
      const double at_m = std::abs(known.SignedDistance(window.PositionOf(landmark)));
      if (at_m / noise.plane_sigma_m * kMaxInnovationRatio <= max_sigma) continue;
      // The row itself has drawn the landmark to the plane. Vision alone would place it farther
      // off by this ratio.
      const double sigma = SigmaAlong(geometry, landmark, known.n, noise);
      const double ratio = 1 + sigma * sigma / (known.row_sigma_m * known.row_sigma_m);
      if (at_m * ratio <= max_sigma * std::hypot(sigma, noise.plane_sigma_m)) continue;
      landmark.planes.Remove(plane);
      ++detached;
    }
  }
  return detached;
}

void WeighPlanes(const FactorNoise& noise, SlidingWindow& window) {
  const std::vector<int> members = window.CountMembers();
  for (std::size_t k = 0; k < members.size(); ++k) {
    window.planes[k].row_sigma_m =
        std::hypot(noise.plane_sigma_m, std::sqrt(members[k]) * noise.plane_common_sigma_m);
  }
}

void RemoveUnsupportedPlanes(int min_landmarks, SlidingWindow& window) {
  const std::vector<int> members = window.CountMembers();
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
