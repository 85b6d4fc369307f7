// SPDX-License-Identifier: BSD-2-Clause
// Reads the two tables that a simulation along a real flight needs: ground truth and IMU of EuRoC
// (Burri et al., IJRR 2016).
#pragma once

#include <filesystem>
#include <vector>

#include "facet/imu/imu_types.h"

namespace facet {

/// state_groundtruth_estimate0/data.csv, at any rate: stamp [ns], p_WB [m], q_WB (w x y z), v_WB
/// [m/s], b_g [rad/s], b_a [m/s^2]. Velocity and biases may be nan or missing; then velocity is
/// zero, biases are nan. Throws std::runtime_error with path and line if the file is missing,
/// malformed or not in order.
std::vector<NavState> LoadGroundTruthCsv(const std::filesystem::path& path);

/// imu0/data.csv: stamp [ns], gyro [rad/s], accel [m/s^2]. Throws like LoadGroundTruthCsv.
std::vector<ImuSample> LoadImuCsv(const std::filesystem::path& path);

}  // namespace facet
