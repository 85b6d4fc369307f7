// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/window_snapshot.h"

#include <algorithm>
#include <cmath>

#include "facet/estimator/window/landmark_depth.h"

namespace facet {

namespace {

// A landmark farther away than this is a direction.
constexpr double kMinInverseDistance = 1e-3;

void AddLandmarks(const SlidingWindow& window, const StereoRig& rig, MapSnapshot& snapshot) {
  std::vector<CameraCentres> centres;
  for (const WindowFrame& frame : window.frames)
    centres.push_back({frame.x.T_WB * rig.T_BC[0].p, frame.x.T_WB * rig.T_BC[1].p});
  for (const WindowLandmark& landmark : window.landmarks()) {
    const double rho = landmark.inverse_distance;
    if (!landmark.has_depth || rho < kMinInverseDistance) continue;
    const SE3 T_WC = window.LeftCameraAt(landmark.host);
    const Vector3d ray_W = T_WC.q * landmark.bearing_H;
    const double information = InverseDistanceInformation(landmark, ray_W, centres);
    snapshot.landmarks.push_back({landmark.id,
                                  T_WC.p + ray_W / rho,
                                  static_cast<int>(landmark.observations.size()),
                                  1 / (rho * rho * std::sqrt(information + 1e-12)),
                                  {}});
    for (int k = 0; k < landmark.planes.count(); ++k) {
      const WindowPlane& plane = window.planes[landmark.planes[k]];
      snapshot.landmarks.back().planes[static_cast<std::size_t>(k)] = plane.id;
    }
  }
  std::sort(snapshot.landmarks.begin(), snapshot.landmarks.end(), [](const auto& a, const auto& b) {
    return a.id < b.id;
  });
}

void AddPlanes(const SlidingWindow& window,
               std::span<const PlaneCovariance> covariances,
               MapSnapshot& snapshot) {
  const std::vector<int> num_landmarks = window.CountPlaneLandmarks();
  for (std::size_t k = 0; k < window.planes.size(); ++k) {
    const WindowPlane& plane = window.planes[k];
    PlaneEstimate& estimate = snapshot.planes.emplace_back();
    estimate.id = plane.id;
    estimate.plane_W = plane.plane();
    estimate.anchor_W = plane.anchor_W;
    estimate.num_landmarks = num_landmarks[k];
    estimate.row_sigma_m = plane.row_sigma_m;
    estimate.is_persistent = plane.persistent;
    for (const auto& [id, covariance] : covariances) {
      if (id == plane.id) estimate.covariance = covariance;
    }
  }
}

}  // namespace

MapSnapshot SnapshotWindow(const SlidingWindow& window,
                           const StereoRig& rig,
                           std::span<const PlaneCovariance> covariances) {
  MapSnapshot snapshot;
  snapshot.latest = window.frames.back().x;
  snapshot.T_WC0 = window.LeftCameraAt(window.newest_frame());
  if (window.calibration)
    snapshot.rig = std::make_shared<const StereoRig>(window.calibration->Refined());
  for (int i = 0; i <= window.newest_frame(); ++i) {
    const WindowFrame& frame = window.frames[i];
    if (frame.is_reported) snapshot.keyframes.push_back({frame.id, frame.x.t, window.BodyAt(i)});
  }
  AddLandmarks(window, rig, snapshot);
  AddPlanes(window, covariances, snapshot);
  for (const WindowRelation& relation : window.relations)
    snapshot.relations.push_back(relation.relation);
  return snapshot;
}

}  // namespace facet
