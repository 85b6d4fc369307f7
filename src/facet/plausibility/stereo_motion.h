// SPDX-License-Identifier: BSD-2-Clause
// How the stereo pair moved, by its images alone. What an estimator makes of images and IMU is a
// compromise, which hides that they contradict each other.
#pragma once

#include <optional>
#include <vector>

#include "facet/calibration/lens_modes.h"
#include "facet/camera/stereo_rig.h"
#include "facet/imu/imu_buffer.h"
#include "facet/map/observation.h"
#include "facet/plausibility/turn_check.h"

namespace facet {

/// Visual odometry from keyframe to keyframe, with the distances that the stereo pair measures.
/// Errors add up: it is for comparing the motion of some keyframes. Not thread-safe.
class StereoMotion {
 public:
  explicit StereoMotion(const StereoRig& rig) { SetRig(rig); }

  /// For the keyframes that follow.
  void SetRig(const StereoRig& rig);

  /// The IMU from the end of the interval before, and the gyroscope's bias as far as it is known.
  /// The accelerometer is not used. The gyroscope begins the search for a motion near its end, goes
  /// on where the images cannot be compared, and is the other side of turn().
  void AddImu(const ImuInterval& imu, const Vector3d& gyro_bias);

  /// The pose of the body in a world of its own. Where too little of the keyframe before is seen
  /// again, the position is not comparable with those of before, but the orientation is.
  SE3 AddKeyframe(const FrameObservations& keyframe);

  /// From the keyframe before to the last one; empty where they cannot be compared.
  const std::optional<DoubleTurn>& turn() const { return turn_; }

  /// At the last keyframe neither the images nor the gyroscope could be followed: its orientation
  /// is not comparable with those of before either.
  bool HasLostOrientation() const { return has_lost_orientation_; }

  /// Places of before are not to be compared with what comes; orientations are, by the gyroscope.
  void ForgetPoints() { before_.clear(); }

 private:
  struct SeenPoint {
    LandmarkId landmark;
    Vector3d p_C;  // as the stereo pair has it
  };
  struct Pair {
    Vector3d p_C;  // in the left camera of before
    Vector3d bearing;
    Matrix<2, 3> across_bearing;
  };
  struct Motion {  // p_now = R p_before + t
    Quaterniond R;
    Vector3d t;
  };

  std::vector<SeenPoint> PointsOf(const FrameObservations& keyframe) const;
  std::vector<Pair> PairsWith(const FrameObservations& keyframe) const;
  std::optional<Motion> Fit(const std::vector<Pair>& pairs, Motion motion) const;

  StereoRig rig_;
  LensFields beside_model_;
  SE3 T_C1C0_, T_CB_;
  double bearing_sigma_ = 0;
  std::vector<SeenPoint> before_;  // by landmark
  // Since the keyframe before, by the gyroscope.
  Quaterniond turned_ = Quaterniond::Identity();
  double dt_s_ = 0;
  bool is_turn_known_ = true;

  SE3 T_WC_;
  std::optional<DoubleTurn> turn_;
  bool has_lost_orientation_ = false;
};

}  // namespace facet
