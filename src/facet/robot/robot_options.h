// SPDX-License-Identifier: BSD-2-Clause
// The parameters of a robot's node, whatever its middleware is.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "facet/facet.h"

namespace facet {
namespace robot {

struct RobotOptions {
  /// From files (api::ReadCalibration). None: CameraInfo of both cameras, with `mount`.
  std::optional<api::Calibration> calibration;
  api::CameraMount mount;
  api::Pose T_base_imu;     ///< IMU to the frame that is output; none given: the IMU's own
  std::string config_file;  ///< as of `facet run`; may be empty
  std::vector<std::string> overrides;  ///< key.path=value
  std::string known_map;   ///< folder of the map of earlier runs, or empty (api::Odometry::Options)
  bool is_started = true;  ///< from the beginning, without Start

  double smoothing_s = 0;       ///< as api::LiveOdometry::Options
  double max_age_s = 1;         ///< the same: no odometry for longer after the newest pair
  int max_waiting_pairs = 2;    ///< the same; more: fewer are dropped, and poses are older
  bool two_threads = false;     ///< the same
  double pair_tolerance_s = 0;  ///< left and right stamps may be this far apart, up to 0.1
  int sample_bits = 16;         ///< of 16-bit images, how many are used
  double silence_s = 1;         ///< a sensor that is silent for longer is an error
  double scene_period_s = 1;    ///< between updates of map and planes, on a keyframe
  double path_period_s = 1;     ///< between paths
  std::size_t max_path = 2000;  ///< poses of a path; a longer one is thinned
};

/// Returns them. Throws api::Error for what is out of range.
const RobotOptions& Checked(const RobotOptions& options);

/// What the odometry is told of them.
api::LiveOdometry::Options LiveOptionsOf(const RobotOptions& options);

/// Throws api::Error where the odometry would not take them, with the calibration if there is one.
/// Returns its notices.
std::vector<std::string> TryOptions(const RobotOptions& options);

}  // namespace robot
}  // namespace facet
