// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/landmark_factors.h"

#include "facet/estimator/factors/point_on_plane_factor.h"
#include "facet/estimator/factors/reprojection_factor.h"

namespace facet {

void LinearizeLandmark(const FrameGeometry& geometry,
                       const std::vector<WindowPlane>& planes,
                       const WindowLandmark& landmark,
                       const FactorNoise& noise,
                       LandmarkBlock& block,
                       LensSums* lens) {
  const LinearizedPoint point(landmark, geometry);
  block.Clear(landmark.observations.size());
  if (lens != nullptr) {
    block.lens.resize(1);
    block.lens.front().W.setZero();
    block.lens.front().has_modes = geometry.estimates_modes();
  }
  for (const WindowObservation& observation : landmark.observations)
    ReprojectionFactor(geometry, landmark, observation, noise).AddTo(point, block, lens);
  if (!landmark.IsOnPlanes()) return;
  for (int k = 0; k < landmark.planes.count(); ++k)
    PointOnPlaneFactor(planes, landmark.planes, k, noise).AddTo(point, block);
}

double LandmarkCost(const FrameGeometry& geometry,
                    const std::vector<WindowPlane>& planes,
                    const WindowLandmark& landmark,
                    const FactorNoise& noise) {
  double cost = 0;
  const HostedPoint point(landmark, geometry.current(landmark.host));
  for (const WindowObservation& observation : landmark.observations)
    cost += ReprojectionFactor(geometry, landmark, observation, noise).Cost(point);
  if (!landmark.IsOnPlanes()) return cost;
  for (int k = 0; k < landmark.planes.count(); ++k)
    cost += PointOnPlaneFactor(planes, landmark.planes, k, noise).Cost(point);
  return cost;
}

}  // namespace facet
