// SPDX-License-Identifier: BSD-2-Clause
// States with more than a pose: states.csv of a result folder, and ground truth in EuRoC's layout
// with velocities and biases.
#pragma once

#include <filesystem>
#include <limits>
#include <vector>

#include "facet/imu/imu_types.h"

namespace facet {

/// What a column does not say is nan.
inline Vector3d Unknown3() {
  return Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

/// One line of states.csv that has a pose, with the 1-sigma of its parts.
struct EstimatedState {
  NavState state;
  int segment = 0;                    ///< stretches between losses; 0 where the file does not say
  Vector3d sigma_p = Unknown3();      ///< [m], in W
  Vector3d sigma_theta = Unknown3();  ///< [rad], in B
  Vector3d sigma_v = Unknown3();
  Vector3d sigma_b_g = Unknown3();
  Vector3d sigma_b_a = Unknown3();
};

/// Columns are found by their names in the first line (px .. baz, sigma_px .. sigma_vz,
/// sigma_bgx .. sigma_baz); biases and their sigmas may be missing. Frames without a pose are left
/// out. Throws InputError with file and line, also for a sigma that is no number from 0 on.
std::vector<EstimatedState> ReadStates(const std::filesystem::path& file);

/// EuRoC csv: t[ns], p, q (wxyz), v, b_g, b_a. Columns behind the pose that are missing or not
/// finite become nan. Sorted by stamp. Throws InputError with file and line.
std::vector<NavState> ReadTrueStates(const std::filesystem::path& file);

}  // namespace facet
