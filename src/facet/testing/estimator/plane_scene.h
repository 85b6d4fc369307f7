// SPDX-License-Identifier: BSD-2-Clause
// A random window with true planes through one of its landmarks, for the tests of planes.
#pragma once

#include "facet/estimator/planes/plane_membership.h"
#include "facet/testing/estimator/test_window.h"

namespace facet::testing {

struct PlaneScene {
  explicit PlaneScene(std::uint64_t seed) : noise(NoiseOfWidth(2.0)) {
    Rng rng(seed);
    TestWindowOptions options;
    options.noise = 0.1;
    test = MakeTestWindow(options, rng);
    landmark = test.window.landmarks().front().id;
    noise.plane_sigma_m = 0.01;
    limits.max_sigma_m = 0.2;
    limits.max_distance_m = 0.1;
  }

  SlidingWindow& window() { return test.window; }

  FrameGeometry Geometry() const {
    FrameGeometry geometry(test.rig);
    geometry.Update(test.window.frames);
    return geometry;
  }

  /// A plane that passes `distance` from the first landmark.
  NewPlane PlaneAt(std::int64_t id, double distance) const {
    const Vector3d n = Vector3d(0.3, -0.2, 0.9).normalized();
    return {PlaneId{id}, Plane{n, n.dot(test.points[0]) - distance}, test.points[0]};
  }

  void Apply(const PlaneAssignments& assignments) {
    ApplyAssignments(assignments, limits, noise, Geometry(), evidence, test.window);
  }

  TestWindow test;
  LandmarkId landmark;  ///< the first one
  FactorNoise noise;
  AttachmentLimits limits;
  PlaneEvidence evidence;
};

/// With sigmas of 1 cm and 0.01 rad.
inline PlaneMeasurement MeasurementOf(PlaneId plane, const WindowFrame& frame) {
  PlaneMeasurement measurement{frame.id, plane};
  measurement.sigma_m = 0.01;
  measurement.sigma_rad = {0.01, 0.01};
  return measurement;
}

}  // namespace facet::testing
