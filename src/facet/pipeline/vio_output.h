// SPDX-License-Identifier: BSD-2-Clause
// What the pipeline tells the outside world after each stereo frame.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "facet/base/stage_timer.h"
#include "facet/imu/causal_state.h"
#include "facet/map/map_snapshot.h"
#include "facet/map/observation.h"
#include "facet/map/plane_record.h"
#include "facet/map/tracking_status.h"
#include "facet/mesh/mesh_snapshot.h"
#include "facet/mesh/surface_map.h"

namespace facet {

/// How the scene has changed, for whoever asked (VioPipeline::RequestSceneUpdate).
struct SceneUpdate {
  std::vector<SurfaceMap::Block> map_blocks;  ///< that changed since the last update
  bool is_partial = false;                    ///< more blocks have changed than one update takes
  std::vector<PlaneRecord> planes;            ///< every plane that was ever a variable
};

/// Plain copy of results; valid after the pipeline is gone.
struct VioOutput {
  FrameId frame;
  Timestamp t;  ///< stamp of the left image
  bool is_keyframe = false;
  TrackingStatus status = TrackingStatus::kInitialising;
  std::string reason;     ///< why the status is not ok, or empty
  bool has_pose = false;  ///< false while initialising; `state` is then meaningless
  /// Which of the stretches between losses the pose belongs to; counts from 0. Across a break poses
  /// are as uncertain as their sigmas say, and may jump.
  int segment = 0;
  NavState state;  ///< causal estimate at t
  /// From W to the map M, which places that were recognised correct; W never jumps, M may. The
  /// identity unless loops.enabled.
  SE3 T_MW;
  bool is_in_map = true;  ///< whether T_MW is known; always, without a map of runs before
  Vector3d sigma_p = Vector3d::Zero();      ///< 1-sigma [m], in W
  Vector3d sigma_theta = Vector3d::Zero();  ///< 1-sigma [rad], in B
  Vector3d sigma_v = Vector3d::Zero();      ///< 1-sigma [m/s], in W
  Vector3d sigma_b_g = Vector3d::Zero();    ///< 1-sigma [rad/s]
  Vector3d sigma_b_a = Vector3d::Zero();    ///< 1-sigma [m/s^2]
  /// Of `state`, theta p v b_g b_a: what the sigmas are the diagonal of.
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();
  /// The same as the estimator itself believes it: what it grows by is what the odometry drifts.
  Matrix<15, 15> solved_covariance = Matrix<15, 15>::Zero();
  CausalState causal;              ///< state and `covariance` for whoever goes on with the IMU
  int num_tracks = 0;              ///< features tracked in this frame
  int num_landmarks = 0;           ///< landmarks in the window
  int num_planes = 0;              ///< in the estimator
  int num_constraints = 0;         ///< landmarks that lie on planes, once per plane
  int imu_gaps = 0;                ///< IMU holes since the previous frame
  bool is_image_repeated = false;  ///< came before, but the camera has moved; not used
  bool is_image_blank = false;     ///< the left image has one grey value everywhere
  bool was_reset = false;  ///< the state was given up after this frame; the next one starts again
  /// What is probably wrong and what to do; set when it begins or comes again later; else empty.
  std::string warning;
  /// Why calibration or IMU cannot be right, once in a run, else empty: whoever sees it should
  /// stop, for what the run finds from here on, and found before, is worth nothing.
  std::string refusal;
  /// Keyframes that left the window with this frame, with their final (smoothed) poses.
  std::vector<KeyframePose> finished_keyframes;
  /// Set on keyframes.
  std::shared_ptr<const MapSnapshot> snapshot;
  /// Set on keyframes with a snapshot, unless the mesh is switched off.
  std::shared_ptr<const MeshSnapshot> mesh;
  /// What was tracked in the frame; null until the frame is done.
  std::shared_ptr<const FrameObservations> observations;
  /// Set on the first keyframe after each request.
  std::shared_ptr<const SceneUpdate> scene_update;
  StageTimes times;
};

/// Told of each frame's pose as soon as it is estimated, before mesh, planes and map are worked on;
/// the output has no mesh yet. May be empty.
using PoseObserver = std::function<void(const VioOutput& output)>;

}  // namespace facet
