// SPDX-License-Identifier: BSD-2-Clause
#include "facet/imu/imu_motion.h"

#include "facet/base/check.h"
#include "facet/geometry/so3.h"

namespace facet {

void ImuMotion::Add(double step_s, const MidpointStep& step) {
  dp += dv * step_s + 0.5 * step_s * step_s * step.acceleration;
  dv += step_s * step.acceleration;
  dR = step.q_end;
  dt_s += step_s;
}

NavState ImuMotion::From(const NavState& start,
                         const Vector3d& g_W,
                         const Vector<9>& correction) const {
  NavState end = start;
  const Quaterniond& q_WB = start.T_WB.q;
  end.T_WB.q = (q_WB * dR * ExpSO3(correction.head<3>())).normalized();
  end.T_WB.p +=
      start.v_WB * dt_s + 0.5 * dt_s * dt_s * g_W + q_WB * (dp + correction.segment<3>(3));
  end.v_WB += g_W * dt_s + q_WB * (dv + correction.tail<3>());
  return end;
}

ImuMotion IntegrateMotion(std::span<const ImuSample> samples, const ImuBias& bias) {
  ImuMotion motion;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const ImuSample &a = samples[i - 1], &b = samples[i];
    FACET_CHECK(b.t >= a.t) << "sample at " << b.t.ns << " after one at " << a.t.ns;
    if (b.t == a.t) continue;
    const StepMeasurement measured = MeasureStep(a, b, bias, Vector3d::Zero());
    motion.Add(measured.dt, MidpointStep(motion.dR, measured));
  }
  return motion;
}

}  // namespace facet
