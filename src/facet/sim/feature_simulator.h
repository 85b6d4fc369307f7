// SPDX-License-Identifier: BSD-2-Clause
// What a front end would hand to the estimator along a known trajectory, without images: tracks of
// points on flat surfaces, with noise, outliers, occlusion and short lives, and IMU samples. The
// truth is known exactly. The same seed gives the same run on every machine.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/map/observation.h"
#include "facet/sim/corridor_scene.h"
#include "facet/sim/room_scene.h"
#include "facet/sim/spline_trajectory.h"

namespace facet {

struct ImuSimulatorOptions {
  bool add_noise = true;       ///< white noise and bias walks of `noise`, and vibration
  ImuNoise noise;              ///< densities and sample rate
  double gyro_vibration = 0;   ///< extra white noise of each sample, 1-sigma per axis [rad/s]
  double accel_vibration = 0;  ///< the same [m/s^2]; EuRoC in flight: 0.5-1 before integration
  /// Mean of the initial bias, and 1-sigma of its spread over the seeds [rad/s], [m/s^2].
  ImuBias bias{Vector3d(-0.0022, 0.0208, 0.0760), Vector3d(-0.013, 0.10, 0.09)};
  double bias_spread_gyro = 5e-3;
  double bias_spread_accel = 0.03;
};

struct FeatureSimulatorOptions {
  double frame_rate_hz = 20;
  int keyframe_every = 4;             ///< every n-th frame is a keyframe, beginning with the first
  bool right_on_every_frame = false;  ///< otherwise the right image is used on keyframes only
  int max_tracks = 150;               ///< per frame; at most one new track per image cell
  double border_px = 8;               ///< tracks end this close to the border of the image
  double mean_track_life_s = 1.0;     ///< of tracks that stay in view (exponential)
  double redetected_share = 0.5;      ///< of new tracks that are lost points, under a new id
  double pixel_sigma = 0.5;  ///< 1-sigma per axis, both images, of each observation for itself
  /// The same of errors that a track keeps for its whole life: of the patch with which it began,
  /// which both images share, and of its match in the right image. The observations state all of
  /// it together.
  double slide_sigma_px = 0, match_sigma_px = 0;
  bool add_pixel_noise = true;
  /// 1-sigma of how far points stand out from their surface, evenly from none to sqrt(12) times
  /// this: real walls have frames, pipes and paper on them [m].
  double roughness_m = 0;
  double outlier_share = 0;  ///< of left and, independently, of right observations
  double outlier_px = 20;    ///< outliers are off by up to this, at least 3 sigma
  double start_s = 0;        ///< the first frame comes this long after the trajectory's begin ...
  double imu_lead_s = 0.05;  ///< ... and this; IMU samples begin before it
  double duration_s = 0;     ///< of the frames; 0: to the end of the trajectory
  RoomOptions room;
  std::optional<CorridorOptions> corridor;  ///< instead of the room
  ImuSimulatorOptions imu;
};

struct TrueLandmark {
  Vector3d p_W = Vector3d::Zero();
  PlaneId surface;  ///< index into SimulatedRun::surfaces
};

struct SimulatedRun {
  StereoRig rig;
  std::vector<FrameObservations> frames;  ///< stamps in the camera clock
  std::vector<ImuSample> imu;             ///< from before the first to after the last frame
  std::vector<NavState> truth;  ///< at frames[i]; stamps in the IMU clock (rig.time_offset)
  std::unordered_map<LandmarkId, TrueLandmark> landmarks;
  std::vector<Surface> surfaces;  ///< surfaces[i].id == PlaneId{i}
};

/// Room, landmarks, track ends, biases and all noise come from `seed`.
/// CHECKs that the trajectory is long enough for at least two frames.
SimulatedRun SimulateFeatures(const SplineTrajectory& trajectory,
                              const StereoRig& rig,
                              const FeatureSimulatorOptions& options,
                              std::uint64_t seed);

/// Samples on [begin, end], and the true biases at the sample stamps.
struct SimulatedImu {
  std::vector<ImuSample> samples;
  std::vector<ImuBias> biases;
};
SimulatedImu SimulateImu(const SplineTrajectory& trajectory,
                         Timestamp begin,
                         Timestamp end,
                         const ImuSimulatorOptions& options,
                         Rng& rng);

}  // namespace facet
