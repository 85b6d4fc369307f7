// SPDX-License-Identifier: BSD-2-Clause
// One simulated flight through the fixed-lag estimator, and optionally the same measurements as one
// batch problem.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "consistency_scenario.h"

#include "facet/estimator/vio_estimator.h"
#include "facet/io/trajectory_file.h"

namespace facet {

/// Estimate against truth at one frame; the truth was moved into the estimator's world by position
/// and heading at the start.
struct FrameError {
  double elapsed_s = 0;  ///< since the first output
  bool is_keyframe = false;
  Matrix3d R_WB = Matrix3d::Identity();
  Vector<15> error = Vector<15>::Zero();  ///< truth (-) estimate: theta p v b_g b_a
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();
};

/// Moves the truth's frame G into W by heading and position: T_WG with T_WG * T_GB ~ T_WB.
SE3 GaugeTransform(const SE3& T_WB, const SE3& T_GB);

/// The frame's moments are left out. `truth` in G.
FrameError CompareWithTruth(const NavState& estimate,
                            const Matrix<15, 15>& covariance,
                            const NavState& truth,
                            const SE3& T_WG);

/// What a front end hands over of simulated observations: right pixels on keyframes only, once
/// there is a pose.
FrameObservations AsFrontEnd(const FrameObservations& simulated, bool is_initialised);

/// Estimate of a plane against the surface that most of its landmarks lie on, at one keyframe.
struct PlaneError {
  double elapsed_s = 0;
  PlaneId plane;
  Vector3d error = Vector3d::Zero();  ///< truth (-) estimate: two tangents [rad], offset [m]
  Matrix3d covariance = Matrix3d::Zero();
};

/// Keyframe poses of the same run and the truth at the same stamps.
struct KeyframeTrajectories {
  std::vector<StampedPose> causal;  ///< when the keyframe came in
  std::vector<StampedPose> final;   ///< when it left the window
  std::vector<StampedPose> batch;   ///< empty without a batch solution
  std::vector<StampedPose> truth;
};

struct ConsistencyRun {
  int num_resets = 0;
  std::vector<FrameError> frames;
  std::vector<PlaneError> planes;
  KeyframeTrajectories keyframes;
  std::optional<FrameError> batch_last;  ///< newest frame of the batch solution
  std::optional<StereoRig> calibration;  ///< as estimated at the end; empty if all of it is held
};

/// What a search for planes would say after a keyframe.
using PlanePolicy = std::function<PlaneAssignments(const FrameObservations&, const MapSnapshot&)>;

ConsistencyRun RunConsistency(const SimulatedRun& run,
                              const ConsistencyOptions& options,
                              bool with_batch,
                              const PlanePolicy& planes = nullptr);

}  // namespace facet
