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

/// What a solve has found known of a landmark, with the frames held.
struct LandmarkInformation {
  Matrix3d V = Matrix3d::Zero();  ///< on two directions across the bearing and the inverse distance
  Matrix<3, 2> basis_H = Matrix<3, 2>::Zero();  ///< the directions, in the host's left camera
  double loss_width = 0;                        ///< of the reprojections
  int num_rows = 0;                             ///< CountRows of then; 0: nothing is known
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
  LandmarkInformation information;  ///< of the last solve that used it
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

/// How many cameras and planes say something of the landmark.
inline int CountRows(const WindowLandmark& landmark) {
  int num_rows = landmark.IsOnPlanes() ? static_cast<int>(landmark.planes.count()) : 0;
  for (const WindowObservation& o : landmark.observations)
    num_rows += o.has_right ? 2 : 1;
  return num_rows;
}

/// Whether the landmark says anything about frames and planes: it has a distance and is seen from
/// two frames, or from one and lies on a plane.
inline bool IsConstraining(const WindowLandmark& landmark) {
  return landmark.has_depth && (landmark.observations.size() >= 2 ||
                                (landmark.IsOnPlanes() && !landmark.observations.empty()));
}

}  // namespace facet
