// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/robot_options.h"

#include <cmath>
#include <string>

#include "facet/robot/motion_covariance.h"

namespace facet {
namespace robot {

namespace {

void CheckPeriod(const char* name, double period_s) {
  if (!(period_s >= 0 && period_s <= 1000))
    throw api::Error(std::string(name) + " must be seconds, from 0 to 1000");
}

/// Some stereo camera: options can be tried with it before the real one is known.
api::Calibration AnyCalibration() {
  api::Calibration calibration;
  for (api::Camera* camera : {&calibration.left, &calibration.right}) {
    camera->width = 640;
    camera->height = 480;
    camera->fx = camera->fy = 400;
    camera->cx = 320;
    camera->cy = 240;
  }
  calibration.right.T_BC.p[0] = 0.1;
  return calibration;
}

}  // namespace

const RobotOptions& Checked(const RobotOptions& options) {
  if (!(options.pair_tolerance_s >= 0 && options.pair_tolerance_s <= 0.1))
    throw api::Error("pair_tolerance_s must be seconds, from 0 to 0.1");
  if (!(options.silence_s > 0)) throw api::Error("silence_s must be seconds, above 0");
  CheckPeriod("scene_period_s", options.scene_period_s);
  CheckPeriod("path_period_s", options.path_period_s);
  double norm2 = 0;
  for (const double q : options.T_base_imu.q)
    norm2 += q * q;
  if (!(std::abs(norm2 - 1) < 1e-3))
    throw api::Error("T_base_imu: the quaternion is not of unit length");
  if (options.max_path < 2) throw api::Error("max_path must be 2 or more");
  return options;
}

api::LiveOdometry::Options LiveOptionsOf(const RobotOptions& options) {
  api::LiveOdometry::Options live;
  live.config_file = options.config_file;
  live.overrides = options.overrides;
  live.known_map = options.known_map;
  live.T_BF = Inverse(options.T_base_imu);
  live.smoothing_s = options.smoothing_s;
  live.max_age_s = options.max_age_s;
  live.max_waiting_pairs = options.max_waiting_pairs;
  live.two_threads = options.two_threads;
  return live;
}

std::vector<std::string> TryOptions(const RobotOptions& options) {
  const api::LiveOdometry trial(options.calibration.value_or(AnyCalibration()),
                                LiveOptionsOf(options));
  return trial.Notices();
}

}  // namespace robot
}  // namespace facet
