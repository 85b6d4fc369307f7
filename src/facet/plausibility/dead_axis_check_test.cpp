// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/dead_axis_check.h"

#include <cmath>
#include <functional>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr Timestamp kBegin{1'400'000'000'000'000'000};

// What an IMU measures whose attitude is R(t), and which is shaken by a(t) in the world; exact.
ImuSample Measure(double t_s,
                  const std::function<Quaterniond(double)>& R,
                  const std::function<Vector3d(double)>& a) {
  constexpr double kStep_s = 1e-4;
  ImuSample sample;
  sample.t = kBegin + FromSeconds(t_s);
  sample.gyro = LogSO3(R(t_s - kStep_s).conjugate() * R(t_s + kStep_s)) / (2 * kStep_s);
  sample.accel = R(t_s).conjugate() * (a(t_s) + Vector3d(0, 0, kGravity));
  return sample;
}

Vector3d Wave(double t_s, const Vector3d& size) {
  return size.cwiseProduct(Vector3d(std::sin(t_s), std::sin(1.3 * t_s + 1), std::sin(1.7 * t_s)));
}

ImuSample InTheHand(double t_s) {
  return Measure(
      t_s,
      [](double s) {
        return ExpSO3(Wave(s, {0.4, 0.3, 0.5}));
      },
      [](double s) { return Wave(2 * s, Vector3d::Ones()); });
}

// Ten seconds of a sensor.
std::vector<DeadAxis> Find(const std::function<ImuSample(double)>& sensor) {
  DeadAxisCheck check;
  std::size_t num = 0;
  for (int i = 0; i <= 2000; ++i) {
    ImuSample sample = sensor(0.005 * i);
    sample.t = kBegin + FromSeconds(0.005 * i);
    if (check.Add(sample)) ++num;
    check.Add(sample);  // the ends of intervals come twice
  }
  EXPECT_EQ(num, check.found().size());
  return check.found();
}

TEST(DeadAxisCheckTest, NamesEachAxisOfBothSensors) {
  EXPECT_THAT(Find(InTheHand), IsEmpty());
  for (const bool is_gyro : {false, true}) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double value : {0.0, 0.25}) {
        const auto found = Find([&](double t_s) {
          ImuSample sample = InTheHand(t_s);
          (is_gyro ? sample.gyro : sample.accel)(axis) = value;
          return sample;
        });
        ASSERT_EQ(found.size(), 1u);
        EXPECT_EQ(found[0].is_gyro, is_gyro);
        EXPECT_EQ(found[0].axis, axis);
        EXPECT_EQ(found[0].value, value);
        EXPECT_EQ(found[0].from, kBegin);
        EXPECT_EQ(found[0].to, kBegin + FromSeconds(10));
      }
    }
  }
}

TEST(DeadAxisCheckTest, AnAxisMayDieLaterAndTwoMayBeDead) {
  const auto found = Find([](double t_s) {
    ImuSample sample = InTheHand(t_s);
    sample.accel.y() = 0;
    if (t_s > 4) sample.accel.z() = 3;
    return sample;
  });
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(ToSeconds(found[1].from - kBegin), 4, 0.01);
  EXPECT_THAT(InWords(found[1]), HasSubstr("axis z of the accelerometer has sent 3 m/s^2"));
}

TEST(DeadAxisCheckTest, SimulatedBodiesMayMoveInAPlaneOrTurnAboutOneAxis) {
  const auto yaw = [](double s) { return ExpSO3(Vector3d(0, 0, 0.5 * std::sin(s))); };
  EXPECT_THAT(Find([&](double t_s) {
                return Measure(t_s, yaw, [](double s) { return Wave(s, {2, 1, 0}); });
              }),
              IsEmpty());
  EXPECT_THAT(Find([&](double t_s) {
                return Measure(t_s, yaw, [](double s) { return Wave(s, {2, 1, 1}); });
              }),
              IsEmpty());
  EXPECT_THAT(Find([](double) {
                return ImuSample{{}, Vector3d::Zero(), {0, 0, kGravity}};
              }),
              IsEmpty());
}

// One digit is 0.15 m/s^2 and 0.02 rad/s, the noise is less than that.
TEST(DeadAxisCheckTest, SensorsWithCoarseDigitsMayRest) {
  int number = 0;
  EXPECT_THAT(Find([&](double) {
                const bool is_up = ++number % 3 == 0;
                return ImuSample{{}, {is_up ? 0.02 : 0.0, 0.02, 0}, {is_up ? 0.15 : 0.3, 0, 9.75}};
              }),
              IsEmpty());
}

TEST(DeadAxisCheckTest, CoarseDigitsAreNoDeadAxis) {
  EXPECT_THAT(Find([](double t_s) {
                ImuSample sample = InTheHand(t_s);
                sample.gyro = (sample.gyro / 0.02).array().round().matrix() * 0.02;
                sample.accel = (sample.accel / 0.15).array().round().matrix() * 0.15;
                return sample;
              }),
              IsEmpty());
}

}  // namespace
}  // namespace facet
