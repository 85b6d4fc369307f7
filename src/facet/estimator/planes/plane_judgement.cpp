// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_judgement.h"

#include <algorithm>
#include <limits>

#include <Eigen/Cholesky>

#include "facet/estimator/factors/relation_factor.h"
#include "facet/geometry/angles.h"

namespace facet {

namespace {

// Mean squared distance of each plane's landmarks from its anchor; infinite for a plane without.
std::vector<double> SquaredExtents(const SlidingWindow& window) {
  std::vector<double> extents(window.planes.size(), 0.0);
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.IsOnPlanes()) continue;
    const Vector3d p_W = window.PositionOf(landmark);
    for (const int plane : landmark.planes) {
      extents[static_cast<std::size_t>(plane)] +=
          (p_W - window.planes[plane].anchor_W).squaredNorm();
    }
  }
  const std::vector<int> num_landmarks = window.CountPlaneLandmarks();
  for (std::size_t k = 0; k < extents.size(); ++k)
    extents[k] = num_landmarks[k] > 0 ? extents[k] / num_landmarks[k]
                                      : std::numeric_limits<double>::infinity();
  return extents;
}

bool AreAtTheSamePlace(const SE3& a, const SE3& b) {
  constexpr double kMaxDistance_m = 0.1, kMaxAngle_rad = 0.09;
  return (a.p - b.p).norm() < kMaxDistance_m && a.q.angularDistance(b.q) < kMaxAngle_rad;
}

}  // namespace

void MarkPersistentPlanes(const std::vector<Matrix3d>& information,
                          const PersistenceLimits& limits,
                          SlidingWindow& window) {
  const auto square = [](double x) { return x * x; };
  const double max_normal = square(limits.max_normal_deg * kDegree);
  const double max_boundary = square(limits.max_boundary_m);
  const double max_offset = square(limits.max_offset_m);
  const std::vector<double> extents = SquaredExtents(window);
  for (std::size_t k = 0; k < window.planes.size(); ++k) {
    const Eigen::LLT<Matrix3d> factor(information[k]);
    if (factor.info() != Eigen::Success) continue;
    const Matrix3d covariance = factor.solve(Matrix3d::Identity());
    const double normal = covariance(0, 0) + covariance(1, 1);
    // Of a plane of little extent the normal only needs to be good enough where its landmarks are.
    const bool has_normal = normal < max_normal || normal * extents[k] < max_boundary;
    if (has_normal && covariance(2, 2) < max_offset) window.planes[k].persistent = true;
  }
}

int DropViolatedRelations(const RelationNoise& noise, double max_sigma, SlidingWindow& window) {
  return static_cast<int>(std::erase_if(window.relations, [&](const WindowRelation& relation) {
    return RelationFactor(window, relation, noise).Error().norm() > max_sigma;
  }));
}

void CutNonPersistentLinks(const std::vector<char>& leaving_landmarks, SlidingWindow& window) {
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    if (leaving_landmarks[l] == 0) continue;
    PlaneLinks& links = window.landmarks()[l].planes;
    for (int k = links.count() - 1; k >= 0; --k) {
      const int plane = links[k];
      if (!window.planes[plane].persistent) links.Remove(plane);
    }
  }
}

void CutMeasurements(const std::vector<char>& leaving_frames, SlidingWindow& window) {
  const auto frame_of = [&](const PlaneMeasurement& s) { return window.IndexOf(s.frame); };
  const auto leaves = [&](const PlaneMeasurement& s) {
    return leaving_frames[static_cast<std::size_t>(frame_of(s))] != 0;
  };
  const auto pose_of = [&](const PlaneMeasurement& s) -> const SE3& {
    return window.frames[frame_of(s)].x.T_WB;
  };
  std::vector<WindowMeasurement> staying = window.measurements;
  std::erase_if(staying, leaves);
  std::erase_if(window.measurements, [&](const PlaneMeasurement& measurement) {
    if (!leaves(measurement)) return false;
    if (!window.planes[window.IndexOf(measurement.plane)].persistent) return true;
    return std::any_of(staying.begin(), staying.end(), [&](const PlaneMeasurement& other) {
      return other.plane == measurement.plane &&
             AreAtTheSamePlace(pose_of(other), pose_of(measurement));
    });
  });
}

void CutNonPersistentRelations(const std::vector<char>& leaving_planes, SlidingWindow& window) {
  const auto is_only_confirmed = [&](PlaneId id) {
    const int plane = window.IndexOf(id);
    const WindowPlane& p = window.planes[plane];
    return leaving_planes[static_cast<std::size_t>(plane)] == 0 && !p.persistent && !p.frozen;
  };
  const auto leaves = [&](PlaneId id) {
    return leaving_planes[static_cast<std::size_t>(window.IndexOf(id))] != 0;
  };
  std::erase_if(window.relations, [&](const WindowRelation& w) {
    const PlaneRelation& r = w.relation;
    if (r.IsUnary()) return false;
    return (leaves(r.a) && is_only_confirmed(r.b)) || (leaves(r.b) && is_only_confirmed(r.a));
  });
}

}  // namespace facet
