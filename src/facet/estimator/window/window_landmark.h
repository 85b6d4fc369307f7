// SPDX-License-Identifier: BSD-2-Clause
// Landmarks of the window and where they were seen.
#pragma once

#include <vector>

#include "facet/estimator/window/measured_ray.h"
#include "facet/estimator/window/window_plane.h"

namespace facet {

/// One landmark in one stereo frame.
struct WindowObservation {
  int frame = 0;  ///< index into SlidingWindow::frames
  bool has_right = false;
  /// [0] left, [1] right.
  MeasuredRay rays[2];
  Vector2d px[2] = {Vector2d::Zero(), Vector2d::Zero()};  ///< measured pixels
  double sigma_px[2] = {1, 1};  ///< 1-sigma of the pixels that the rays are whitened with
  double sigma_match_px = 0;    ///< see FeatureObservation
};

/// A point as bearing and inverse distance in the left camera of its host frame (docs/math.md,
/// section 3.1).
struct WindowLandmark {
  LandmarkId id;
  int host = 0;                                 ///< index into SlidingWindow::frames
  bool has_depth = false;                       ///< false until stereo or parallax gave a distance
  Vector3d bearing_H{0, 0, 1};                  ///< unit vector in the host's left camera
  double inverse_distance = 0;                  ///< 1/m, >= 0
  std::vector<WindowObservation> observations;  ///< in order of time; at most one per frame
  PlaneLinks planes;
  /// What the last solve has found known of two directions across the bearing (TangentBasis) and of
  /// the inverse distance, with the frames held; zero before.
  Matrix3d information = Matrix3d::Zero();
  /// Keyframes at which it was where the motion by the IMU puts it; below 0 it has moved.
  int num_confirmed = 0;
  bool is_projection = false;  ///< pipeline SP: the paper's projection noise and loss

  bool IsOnProbation() const { return num_confirmed < 0; }
  /// It has agreed with the IMU often enough to say what moves.
  bool IsWitness() const { return num_confirmed >= kWitnessAfter; }
  static constexpr int kWitnessAfter = 3;  // keyframes

  /// A point this far away is not tied to planes: its distance means nothing.
  static constexpr double kMinPlaneInverseDistance = 0.02;
  bool IsOnPlanes() const {
    return planes.count() > 0 && has_depth && inverse_distance > kMinPlaneInverseDistance;
  }
};

/// Whether the landmark says anything about frames and planes: it has a distance and is seen from
/// two frames, or from one and lies on a plane.
inline bool IsConstraining(const WindowLandmark& landmark) {
  return landmark.has_depth && (landmark.observations.size() >= 2 ||
                                (landmark.IsOnPlanes() && !landmark.observations.empty()));
}

}  // namespace facet
