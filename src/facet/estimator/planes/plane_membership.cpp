// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_membership.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "facet/estimator/factors/landmark_factors.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

// Of a landmark that is known to ten times the sigma of planes' landmarks.
constexpr double kMaxInnovationRatio = 10;

// Which share of a surface's unevenness all landmarks of a window have in common: waves of ground
// are longer than what is seen of it at once.
constexpr double kCommonUnevenness = 0.3;

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

void AttachLandmarks(const std::vector<PlaneAttachment>& attachments,
                     const AttachmentLimits& limits,
                     const FactorNoise& noise,
                     const FrameGeometry& geometry,
                     const PlaneEvidence& evidence,
                     SlidingWindow& window) {
  for (const PlaneAttachment& attachment : attachments) {
    WindowLandmark* landmark = window.Find(attachment.landmark);
    const int index = window.IndexOf(attachment.plane);
    if (landmark == nullptr || index < 0 || landmark->planes.Contains(index)) continue;
    if (!landmark->has_depth || landmark->observations.empty() ||
        landmark->inverse_distance <= WindowLandmark::kMinPlaneInverseDistance) {
      continue;
    }
    const WindowPlane& plane = window.planes[index];
    const double sigma_m = SigmaAlong(geometry, *landmark, plane.n, noise);
    if (!(sigma_m <= attachment.length_scale * limits.max_sigma_m)) continue;
    const double distance_m = std::abs(plane.SignedDistance(window.PositionOf(*landmark)));
    const double max_distance_m = std::max({limits.max_distance_m,
                                            attachment.max_distance_m,
                                            3 * std::hypot(sigma_m, noise.plane_sigma_m)});
    if (distance_m > max_distance_m || landmark->planes.count() == PlaneLinks::kMax) continue;
    landmark->planes.Add(index,
                         attachment.length_scale * evidence.RowScale(window, *landmark, index));
  }
}

}  // namespace

void ApplyAssignments(const PlaneAssignments& assignments,
                      const AttachmentLimits& limits,
                      const FactorNoise& noise,
                      const FrameGeometry& geometry,
                      const PlaneEvidence& evidence,
                      SlidingWindow& window) {
  for (const NewPlane& created : assignments.created) {
    if (window.IndexOf(created.id) >= 0) continue;
    window.planes.emplace_back(
        created.id, created.plane_W, created.centroid_W, noise.plane_sigma_m);
  }
  for (const auto& [landmark_id, plane_id] : assignments.detached) {
    WindowLandmark* landmark = window.Find(landmark_id);
    const int plane = window.IndexOf(plane_id);
    if (landmark != nullptr && plane >= 0) landmark->planes.Remove(plane);
  }
  for (const auto& [plane_id, sigma_m] : assignments.unevenness) {
    const int plane = window.IndexOf(plane_id);
    if (plane >= 0) window.planes[plane].unevenness_m = sigma_m;
  }
  AttachLandmarks(assignments.attached, limits, noise, geometry, evidence, window);
  for (const PlaneRelation& relation : assignments.relations)
    window.AddRelation(relation);
  for (const PlaneMeasurement& measurement : assignments.measurements) {
    const int plane = window.IndexOf(measurement.plane), frame = window.IndexOf(measurement.frame);
    if (plane < 0 || frame < 0) continue;
    WindowMeasurement& added = window.measurements.emplace_back(measurement);
    if (!window.calibration) continue;
    const WindowFrame& measured_in = window.frames[frame];
    SetCalibrationColumns(*window.calibration,
                          measured_in.Rates(),
                          measured_in.x.T_WB.q.conjugate() * window.planes[plane].n,
                          added);
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
      const double row_sigma_m = landmark.planes.row_scale(k) * known.row_sigma_m;
      const double ratio = 1 + sigma * sigma / (row_sigma_m * row_sigma_m);
      if (at_m * ratio <= max_sigma * std::hypot(sigma, noise.plane_sigma_m)) continue;
      landmark.planes.Remove(plane);
      ++detached;
    }
  }
  return detached;
}

void WeighPlanes(const FactorNoise& noise, SlidingWindow& window) {
  std::vector<double> num_rows(window.planes.size(), 0.0);  // those that count less are less
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.IsOnPlanes()) continue;
    for (int k = 0; k < landmark.planes.count(); ++k)
      num_rows[static_cast<std::size_t>(landmark.planes[k])] +=
          1 / (landmark.planes.row_scale(k) * landmark.planes.row_scale(k));
  }
  for (std::size_t k = 0; k < num_rows.size(); ++k) {
    WindowPlane& plane = window.planes[k];
    const double common_m =
        std::hypot(noise.plane_common_sigma_m, kCommonUnevenness * plane.unevenness_m);
    plane.row_sigma_m =
        std::hypot(noise.plane_sigma_m, plane.unevenness_m, std::sqrt(num_rows[k]) * common_m);
  }
}

void RemoveSparsePlanes(int min_landmarks, SlidingWindow& window) {
  const std::vector<int> num_landmarks = window.CountPlaneLandmarks();
  const auto is_measured = [&](PlaneId id) {
    return std::any_of(window.measurements.begin(),
                       window.measurements.end(),
                       [&](const auto& measurement) { return measurement.plane == id; });
  };
  for (int k = static_cast<int>(window.planes.size()) - 1; k >= 0; --k) {
    const WindowPlane& plane = window.planes[k];
    const int needed = is_measured(plane.id) ? 1 : min_landmarks;
    if (!plane.frozen && num_landmarks[k] < needed) window.RemovePlane(k);
  }
}

}  // namespace facet
