// SPDX-License-Identifier: BSD-2-Clause
#include "scaled_run.h"

#include "facet/imu/imu_types.h"

namespace facet {

SimulatedRun ScaledRun(SimulatedRun run, const SplineTrajectory& trajectory, double scale) {
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
  // f = R^T (a - g) + e becomes R^T (s a - g) + s e.
  for (ImuSample& sample : run.imu) {
    const Quaterniond q_BW = trajectory.At(sample.t).state.T_WB.q.conjugate();
    sample.accel = scale * sample.accel + (scale - 1) * (q_BW * GravityInWorld());
  }
  return run;
}

ConsistencyOptions ScaledOptions(ConsistencyOptions options, double scale) {
  options.simulator.imu.noise.accel_noise *= scale;
  options.simulator.imu.noise.accel_walk *= scale;
  options.estimator.start.sigma_position *= scale;
  return options;
}

}  // namespace facet
