// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/imu_sensor.h"

#include <numbers>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/sim/flight.h"
#include "facet/sim/vibration.h"

namespace facet {
namespace {

SplineTrajectory Fly(FlightKind kind, std::uint64_t seed) {
  const std::vector<Vector3d> route_W = {{-2, -2, 1}, {2, -1, 1.6}, {1.5, 2, 1.2}, {-2, 1.5, 2}};
  FlightOptions options;
  options.duration_s = 14;
  options.seed = seed;
  return SplineTrajectory::Fit(MakeFlightPoses(kind, route_W, options), {0.05, 1e-6});
}

/// Strapdown integration: the rate of rotation is taken as linear between samples, with the term
/// for its changing direction; specific force as linear in the world.
NavState Integrate(NavState state, const std::vector<ImuSample>& samples) {
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const ImuSample &a = samples[i - 1], &b = samples[i];
    const double dt = ToSeconds(b.t - a.t);
    const Vector3d turn = 0.5 * dt * (a.gyro + b.gyro) + dt * dt / 12 * a.gyro.cross(b.gyro);
    const Quaterniond q_end = (state.T_WB.q * ExpSO3(turn)).normalized();
    const Vector3d a_begin = state.T_WB.q * a.accel + GravityInWorld();
    const Vector3d a_end = q_end * b.accel + GravityInWorld();
    state.T_WB.p += dt * state.v_WB + dt * dt / 6 * (2 * a_begin + a_end);
    state.v_WB += 0.5 * dt * (a_begin + a_end);
    state.T_WB.q = q_end;
  }
  return state;
}

TEST(ImuSensorTest, NoiseFreeSamplesAtOneKilohertzReproduceTheTrajectory) {
  ImuSensorOptions options;
  options.add_noise = options.add_bias = false;
  options.rate_hz = 1000;
  for (const char* name : {"gentle", "fast", "aggressive", "hover", "hand-held", "walk"}) {
    const SplineTrajectory trajectory = Fly(*FlightKindFromText(name), 3);
    const Timestamp begin = trajectory.begin() + FromSeconds(3);
    const SensedImu imu = SenseImu(
        trajectory, begin, begin + FromSeconds(10), {}, options, VibrationKind::kRotors, 1);
    ASSERT_EQ(imu.samples.size(), 10001);
    const NavState end = Integrate(imu.truth.front(), imu.samples);
    const double position_mm = 1e3 * (end.T_WB.p - imu.truth.back().T_WB.p).norm();
    const double rotation_deg =
        LogSO3(end.T_WB.q.conjugate() * imu.truth.back().T_WB.q).norm() * 180 / std::numbers::pi;
    std::printf("%-10s %.4f mm, %.6f deg after 10 s\n", name, position_mm, rotation_deg);
    EXPECT_LT(position_mm, 1) << name;
    EXPECT_LT(rotation_deg, 0.005) << name;
  }
}

TEST(ImuSensorTest, SameSeedSameSamplesAndAnotherSeedOthers) {
  const SplineTrajectory trajectory = Fly(FlightKind::kGentle, 1);
  const auto sense = [&](std::uint64_t seed) {
    const Timestamp begin = trajectory.begin();
    return SenseImu(
        trajectory, begin, begin + FromSeconds(1), {}, {}, VibrationKind::kRotors, seed);
  };
  const SensedImu a = sense(1), b = sense(1), c = sense(2);
  for (std::size_t i = 0; i < a.samples.size(); ++i)
    ASSERT_EQ(a.samples[i].accel, b.samples[i].accel);
  EXPECT_NE(a.samples[5].accel, c.samples[5].accel);
}

TEST(ImuSensorTest, ReadingsStopAtTheRangeAndComeInSteps) {
  const SplineTrajectory trajectory = Fly(FlightKind::kAggressive, 1);
  ImuSensorOptions options;
  options.max_accel = 9;
  options.accel_step = 0.5;
  const Timestamp begin = trajectory.begin();
  const SensedImu imu =
      SenseImu(trajectory, begin, begin + FromSeconds(2), {}, options, VibrationKind::kRotors, 1);
  double largest = 0;
  for (const ImuSample& sample : imu.samples) {
    largest = std::max(largest, sample.accel.cwiseAbs().maxCoeff());
    EXPECT_DOUBLE_EQ(sample.accel.x(), 0.5 * std::round(sample.accel.x() / 0.5));
  }
  EXPECT_DOUBLE_EQ(largest, 9);
}

TEST(VibrationTest, HasTheStrengthThatWasMeasuredInFlight) {
  Vibration vibration(VibrationKind::kRotors, 200, Rng(1));
  Vector<6> sum = Vector<6>::Zero();
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i)
    sum += vibration.Next().cwiseAbs2();
  const Vector<6> rms = (sum / kCount).cwiseSqrt();
  Vector<6> measured;  // 10 to 100 Hz, mean of three flights
  measured << 0.021, 0.048, 0.035, 1.06, 0.51, 0.79;
  for (int k = 0; k < 6; ++k)
    EXPECT_NEAR(rms(k) / measured(k), 1, 0.1) << k;
}

}  // namespace
}  // namespace facet
