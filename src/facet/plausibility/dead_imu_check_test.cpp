// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/dead_imu_check.h"

#include <cmath>
#include <functional>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct Verdict {
  std::string words;
  double after_s = 0;
};

// Ten seconds, frame by frame: the sensor's values at a time [s], and how fast the image moves.
Verdict Judge(const std::function<ImuSample(double)>& sensor, double px_per_s) {
  DeadImuCheck check;
  const Timestamp begin{1'400'000'000'000'000'000};
  Verdict verdict;
  for (int frame = 0; frame < 200; ++frame) {
    std::vector<ImuSample> samples;
    for (int i = 0; i <= 10; ++i) {
      const double t_s = 0.05 * frame + 0.005 * i;
      samples.push_back(sensor(t_s));
      samples.back().t = begin + FromSeconds(t_s);
    }
    std::vector<FeatureObservation> features;
    for (int i = 0; i < 30; ++i) {
      // A landmark is seen for a second.
      FeatureObservation& feature = features.emplace_back();
      feature.landmark = LandmarkId{100 * (frame / 20) + i};
      feature.px_left = Vector2d(10.0 * i + px_per_s * 0.05 * frame, 50);
    }
    const std::string words = check.Add(samples, features);
    if (words.empty()) continue;
    EXPECT_THAT(verdict.words, IsEmpty()) << "said twice";
    verdict = {words, 0.05 * (frame + 1)};
  }
  return verdict;
}

ImuSample Constant(const Vector3d& gyro, const Vector3d& accel) {
  return {{}, gyro, accel};
}

TEST(DeadImuCheckTest, NamesAnImuThatSendsOneValueWhileTheImagesMove) {
  const Verdict verdict =
      Judge([](double) { return Constant(Vector3d(0.01, 0, 0), Vector3d(9.81, 0.1, 0)); }, 20);
  EXPECT_THAT(verdict.words,
              AllOf(HasSubstr("the IMU has sent one value"),
                    HasSubstr("gyroscope 0.01 0 0"),
                    HasSubstr("while the images move")));
  EXPECT_LE(verdict.after_s, 2);
}

TEST(DeadImuCheckTest, WhatIsNotGravityNeedsNoImages) {
  const Verdict nothing =
      Judge([](double) { return Constant(Vector3d::Zero(), Vector3d::Zero()); }, 0);
  EXPECT_THAT(nothing.words, HasSubstr("accelerometer 0 0 0 m/s^2"));
  EXPECT_LE(nothing.after_s, 2);
}

TEST(DeadImuCheckTest, AnAccelerometerMayBeDeadAlone) {
  const Verdict verdict = Judge(
      [](double t_s) {
        return Constant(Vector3d(0.1 * std::sin(9 * t_s), 0, 0), {0, 0, 9.81});
      },
      20);
  EXPECT_THAT(verdict.words, HasSubstr("the accelerometer has sent one value"));
}

TEST(DeadImuCheckTest, ASimulatedSensorAtRestIsLeftAlone) {
  const Verdict verdict = Judge([](double) { return Constant(Vector3d::Zero(), {0, 0, 9.81}); }, 0);
  EXPECT_THAT(verdict.words, IsEmpty());
}

TEST(DeadImuCheckTest, ASensorThatLivesIsLeftAloneWhateverComesLater) {
  const Verdict verdict = Judge(
      [](double t_s) {
        return Constant(Vector3d::Zero(), {0, 0, t_s < 0.1 ? 9.81 + t_s : 0.0});
      },
      20);
  EXPECT_THAT(verdict.words, IsEmpty());
}

}  // namespace
}  // namespace facet
