// SPDX-License-Identifier: BSD-2-Clause
#include "scaled_run.h"

namespace facet {

SimulatedRun ScaledRun(SimulatedRun run, double scale) {
  for (SE3& T_BC : run.rig.T_BC)
    T_BC.p *= scale;
  for (NavState& truth : run.truth) {
    truth.T_WB.p *= scale;
    truth.v_WB *= scale;
    truth.bias.b_a *= scale;
  }
  for (auto& [id, landmark] : run.landmarks)
    landmark.p_W *= scale;
  for (Surface& surface : run.surfaces) {
    surface.center_W *= scale;
    surface.half_u *= scale;
    surface.half_v *= scale;
  }
  for (ImuSample& sample : run.imu)
    sample.accel *= scale;
  return run;
}

ConsistencyOptions ScaledOptions(ConsistencyOptions options, double scale) {
  options.simulator.imu.noise.accel_noise *= scale;
  options.simulator.imu.noise.accel_walk *= scale;
  options.estimator.imu.gravity_mps2 *= scale;
  options.estimator.imu.max_accel_noise *= scale;
  options.estimator.start.sigma_position *= scale;
  options.estimator.start.sigma_velocity *= scale;
  options.estimator.start.sigma_accel_bias *= scale;
  return options;
}

}  // namespace facet
