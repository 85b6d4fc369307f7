// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/imu_joiner.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace facet {
namespace {

Timestamp Ms(std::int64_t ms) {
  return {ms * 1000000};
}

TEST(ImuJoinerTest, AccelerationsAreInterpolatedToTheStampsOfTheRates) {
  ImuJoiner joiner;
  joiner.AddGyro(Ms(0), {9, 9, 9});  // before the first acceleration
  joiner.AddAccel(Ms(2), {1, 0, 0});
  joiner.AddGyro(Ms(5), {0, 1, 0});
  joiner.AddGyro(Ms(10), {0, 2, 0});
  EXPECT_TRUE(joiner.samples().empty()) << "the acceleration behind them is not there yet";
  joiner.AddAccel(Ms(12), {2, 10, 0});
  ASSERT_EQ(joiner.samples().size(), 2u);
  EXPECT_EQ(joiner.samples()[0].t, Ms(5));
  EXPECT_EQ(joiner.samples()[0].gyro, Vector3d(0, 1, 0));
  EXPECT_TRUE(joiner.samples()[0].accel.isApprox(Vector3d(1.3, 3, 0), 1e-12));
  EXPECT_TRUE(joiner.samples()[1].accel.isApprox(Vector3d(1.8, 8, 0), 1e-12));
  ASSERT_EQ(joiner.Warnings().size(), 1u);
  EXPECT_THAT(joiner.Warnings()[0], ::testing::HasSubstr("1 angular rates"));
}

TEST(ImuJoinerTest, AGapOfTheAccelerometerIsAGap) {
  ImuJoiner joiner;
  joiner.AddAccel(Ms(0), {0, 0, 0});
  for (int t = 5; t < 200; t += 5)
    joiner.AddGyro(Ms(t), {0, 0, 0});
  joiner.AddAccel(Ms(200), {0, 0, 0});
  joiner.AddGyro(Ms(204), {0, 0, 0});
  joiner.AddAccel(Ms(208), {0, 0, 0});
  ASSERT_EQ(joiner.samples().size(), 1u);
  EXPECT_EQ(joiner.samples()[0].t, Ms(204));
}

TEST(ImuJoinerTest, SamplesThatCannotBeUsedAreCounted) {
  ImuJoiner joiner;
  ImuSample sample;
  sample.gyro = sample.accel = {1, 2, 3};
  for (const int t : {5, 10, 10, 7, 15}) {
    sample.t = Ms(t);
    joiner.AddSample(sample);
  }
  sample.t = Ms(20);
  sample.gyro.x() = std::numeric_limits<double>::quiet_NaN();
  joiner.AddSample(sample);
  EXPECT_EQ(joiner.samples().size(), 3u);
  EXPECT_THAT(joiner.Warnings(),
              ::testing::ElementsAre(::testing::HasSubstr("1 IMU messages are not finite"),
                                     ::testing::HasSubstr("2 IMU messages repeat")));
  joiner.Clear();
  EXPECT_TRUE(joiner.samples().empty());
  EXPECT_TRUE(joiner.Warnings().empty());
}

}  // namespace
}  // namespace facet
