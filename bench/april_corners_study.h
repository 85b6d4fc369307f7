// SPDX-License-Identifier: BSD-2-Clause
// The back end on EuRoC's camera-IMU calibration recording: real corners, real IMU, no image
// processing, and a board of 144 corners whose places are known to a fraction of a millimetre.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "facet/estimator/vio_estimator.h"
#include "facet/eval/trajectory_error.h"
#include "facet/imu/imu_buffer.h"
#include "facet/io/calibration_file.h"
#include "facet/io/trajectory_file.h"

namespace facet {

/// One corner of the board in one stereo frame, raw pixels.
struct CornerObservation {
  std::optional<Vector2d> px_left;
  std::optional<Vector2d> px_right;
};

struct AprilRecording {
  Calibration calibration;
  std::map<Timestamp, std::map<int, CornerObservation>> frames;  ///< by stamp and corner
  ImuBuffer imu;
  std::map<int, Vector3d> corners_G;  ///< places on the board, by corner
  std::vector<StampedPose> truth;     ///< body in the board frame G, from single views
};

/// `folder` is euroc_april_corners, `mav0` the ASL folder with the calibration. Throws InputError.
AprilRecording LoadAprilRecording(const std::filesystem::path& folder,
                                  const std::filesystem::path& mav0);

struct AprilOptions {
  EstimatorOptions estimator;
  int keyframe_every = 4;     ///< right observations on keyframes only
  double pixel_sigma = 0.5;   ///< 1-sigma per axis
  int max_unseen_frames = 5;  ///< a corner that returns later is a new landmark
  /// Planes as variables, which corner lies on which being known: 0 none, 1 the board, 4 its
  /// quarters.
  int num_planes = 0;
  double start_s = 0;          ///< into the recording
  bool hide_quarters = false;  ///< each quarter of the board is hidden for 8 s, one after the other
};

/// The landmarks of one keyframe's snapshot after rigid alignment with the board.
struct BoardFit {
  int num_landmarks = 0;
  double rms_m = 0;       ///< distance from the true corners
  double flatness_m = 0;  ///< rms distance from the landmarks' own best plane
};

struct CostSummary {
  double mean_ms = 0, median_ms = 0, p99_ms = 0;
};

/// Thread CPU time of the back end.
struct AprilCost {
  CostSummary all, keyframes;
};

struct AprilRun {
  int num_frames = 0;
  int num_resets = 0;
  std::vector<StampedPose> poses;  ///< causal, one per frame with a state
  std::vector<BoardFit> fits;      ///< one per keyframe
  std::vector<Plane> planes_W;     ///< of every keyframe
  AprilCost cost;
};

AprilRun RunAprilCorners(const AprilRecording& recording, const AprilOptions& options);

struct AprilFigures {
  double coverage = 0;  ///< share of the frames with a pose
  TrajectoryError trajectory;
  ErrorStatistics rotation_deg;  ///< of the causal poses, after the alignment of the positions
  double landmark_rms_m = 0;     ///< median over the snapshots
  double flatness_m = 0;         ///< median over the snapshots
  /// Angle between the planes and the board, over all keyframes after the alignment of the
  /// positions; zero without planes.
  ErrorStatistics plane_angle_deg;
};

AprilFigures EvaluateAprilCorners(const AprilRecording& recording, const AprilRun& run);

}  // namespace facet
