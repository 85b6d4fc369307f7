// SPDX-License-Identifier: BSD-2-Clause
// A smooth motion through recorded poses: a uniform quintic B-spline in position and in the
// quaternion's components (normalised on evaluation). All derivatives are analytic, so that
// simulated IMU samples and poses agree exactly; recorded ground truth itself is too noisy for
// that.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "facet/imu/imu_types.h"

namespace facet {

struct SplineOptions {
  double knot_interval_s =
      0.1;  ///< raising it smooths more: motion above about 0.3 / interval Hz is lost
  double smoothing = 1e-4;  ///< weight of third differences; bridges holes in the recording
};

/// How far a path that is fitted to a recorded flight and its IMU trusts the IMU. Recorded poses
/// are right in the long run and wander in between; the IMU is the other way round.
struct ImuFitOptions {
  SplineOptions spline{0.05, 1e-6};
  double rotation_time_s = 10;   ///< the rotation follows the gyroscope on shorter times than this
  double position_time_s = 0.5;  ///< the position follows the accelerometer on shorter ones
};

/// Everything about the motion at one moment.
struct TrajectoryPoint {
  NavState state;                   ///< biases are zero
  Vector3d w_B = Vector3d::Zero();  ///< angular rate [rad/s]
  Vector3d a_W = Vector3d::Zero();  ///< acceleration of the body's origin in W [m/s^2]
};

/// Thread-safe (immutable).
class SplineTrajectory {
 public:
  /// Least squares through the poses of `states` (in order of time; velocities and biases are not
  /// used). CHECKs that there are at least two of them, one second or more apart.
  static SplineTrajectory Fit(std::span<const NavState> states, const SplineOptions& options = {});

  /// Least squares through the poses and, for the derivatives, through the samples, from which the
  /// biases of `states` are taken off: on short times the path does what the IMU measured. CHECKs
  /// like Fit. Samples outside the time of the poses are not used.
  static SplineTrajectory FitWithImu(std::span<const NavState> states,
                                     std::span<const ImuSample> imu,
                                     const ImuFitOptions& options = {});

  /// The same motion in another world: T_NW times each pose.
  SplineTrajectory MovedBy(const SE3& T_NW) const;

  Timestamp begin() const { return begin_; }
  Timestamp end() const { return end_; }

  /// CHECKs that t lies between begin and end.
  TrajectoryPoint At(Timestamp t) const;

  /// What a perfect IMU measures: angular rate and specific force in B.
  ImuSample IdealImuAt(Timestamp t) const;

 private:
  static constexpr int kDegree = 5;
  using Coefficients = Vector<7>;  // position, quaternion x y z w (not normalised)
  class LeastSquares;

  /// Value, first and second derivative of the seven components.
  std::array<Coefficients, 3> Evaluate(double seconds) const;

  Timestamp begin_, end_;
  double knot_interval_s_ = 0;
  std::vector<Coefficients> control_points_;
};

/// Poses at 200 Hz of a made-up flight in a volume of about 4 x 3 x 1.5 m, for tests without
/// recorded data: speeds around 1 m/s, turning, body axes as in EuRoC (x up, z forward). Differs
/// with the seed.
std::vector<NavState> MakeFlight(double duration_s, std::uint64_t seed);

}  // namespace facet
