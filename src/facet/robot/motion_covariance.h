// SPDX-License-Identifier: BSD-2-Clause
// From the covariances of facet/facet.h (rotation on the right, in the moving frame; position and
// velocity in the world) to those of nav_msgs/Odometry (position, then rotation about the fixed
// axes of the world; velocities along the axes of the moving frame).
#pragma once

#include <array>

#include "facet/robot/robot_output.h"

namespace facet {
namespace robot {

/// 15 x 15, row by row: theta p v b_g b_a.
using StateCovariance = std::array<double, 225>;

/// T_WA * T_AB.
api::Pose Compose(const api::Pose& T_WA, const api::Pose& T_AB);
api::Pose Inverse(const api::Pose& T_AB);
/// A vector along the axes of A, from one along the world's.
api::Vec3 InFrame(const api::Pose& T_WA, const api::Vec3& v_W);

/// Of T_WB * T_BF. `covariance` is that of the state of B.
Covariance6 PoseCovariance(const api::Pose& T_WB,
                           const api::Pose& T_BF,
                           const StateCovariance& covariance);

/// Of linear and angular velocity of F along the axes of F. `motion` is of F; its biases are the
/// IMU's, and `T_BF` turns that of the gyroscope. `gyro_variance`: of one sample, white
/// [rad^2/s^2].
Covariance6 TwistCovariance(const api::Motion& motion, const api::Pose& T_BF, double gyro_variance);

}  // namespace robot
}  // namespace facet
