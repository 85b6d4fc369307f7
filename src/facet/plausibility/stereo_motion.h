// SPDX-License-Identifier: BSD-2-Clause
// How the stereo pair moved, by its images alone. What an estimator makes of images and IMU is a
// compromise, which hides that they contradict each other.
#pragma once

#include <optional>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/imu/imu_buffer.h"
#include "facet/map/observation.h"
#include "facet/plausibility/turn_check.h"

namespace facet {

/// Visual odometry from keyframe to keyframe, with the distances that the stereo pair measures.
/// Errors add up: it is for comparing the motion of some keyframes. Not thread-safe.
class StereoMotion {
 public:
  explicit StereoMotion(const StereoRig& rig) : given_(rig) { SetRig(rig); }

  /// For the keyframes that follow.
  void SetRig(const StereoRig& rig);
  /// From here on turns are as the rig has them that was set last.
  void ForgetGivenRig() { given_.reset(); }

  /// The IMU from the end of the interval before. Only the gyroscope is used, and only to begin the
  /// search near its end. `gyro_bias`: as far as it is known.
  void AddImu(const ImuInterval& imu, const Vector3d& gyro_bias);

  /// The pose of the body, in the frame of the left camera at the first keyframe since the last
  /// break. Where too little of the keyframe before is seen again, this one is the first.
  SE3 AddKeyframe(const FrameObservations& keyframe);

  /// The last keyframe was the first one: there is nothing to compare it with.
  bool IsAtBeginning() const { return !turn_; }

  /// From the keyframe before to the last one, as the focal length and the gyroscope's scale of the
  /// given rig have it; empty at the beginning.
  const std::optional<DoubleTurn>& turn() const { return turn_; }

  /// What comes is not to be compared with what was.
  void Break();

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

  std::optional<StereoRig> given_;
  StereoRig rig_;
  SE3 T_C1C0_, T_CB_;
  double bearing_sigma_ = 0;
  std::vector<SeenPoint> before_;                 // by landmark
  Quaterniond turned_ = Quaterniond::Identity();  // of the body since then, by the gyroscope
  double dt_s_ = 0;                               // since then
  SE3 T_WC_;
  std::optional<DoubleTurn> turn_;
};

}  // namespace facet
