// SPDX-License-Identifier: BSD-2-Clause
#include "facet/imu/imu_screen.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "facet/base/random.h"

namespace facet {
namespace {

constexpr double kStep_s = 0.005;

Timestamp StampOf(int i) {
  return Timestamp{} + FromSeconds(i * kStep_s);
}

/// A hand-held IMU that turns and shakes, with the noise of an ADIS16448.
std::vector<ImuSample> Motion(int count, double gyro_noise = 2.4e-3, double accel_noise = 0.028) {
  Rng rng(3);
  std::vector<ImuSample> samples;
  for (int i = 0; i < count; ++i) {
    const double t = i * kStep_s;
    ImuSample sample{StampOf(i),
                     Vector3d(0.9 * std::sin(4 * t), 0.5 * std::cos(2.3 * t), 0.3 * std::sin(t)),
                     Vector3d(2 * std::sin(5 * t), std::sin(7 * t), 9.81 + std::cos(6 * t))};
    sample.gyro += gyro_noise * rng.Normal3();
    sample.accel += accel_noise * rng.Normal3();
    samples.push_back(sample);
  }
  return samples;
}

struct Screened {
  std::deque<ImuSample> samples;
  ImuScreenCounts counts;
};

Screened Screen(const std::vector<ImuSample>& samples) {
  ImuScreen screen;
  Screened result;
  for (const ImuSample& sample : samples)
    screen.Add(sample, result.samples);
  result.counts = screen.counts();
  return result;
}

bool HasDoubt(const ImuSample& sample) {
  return !sample.gyro_doubt.isZero(0) || !sample.accel_doubt.isZero(0);
}

TEST(ImuScreenTest, CleanMotionPassesUnchanged) {
  for (const double noise : {0.0, 1.0, 10.0}) {
    const std::vector<ImuSample> motion = Motion(4000, 2.4e-3 * noise, 0.028 * noise);
    const Screened screened = Screen(motion);
    ASSERT_EQ(screened.samples.size(), motion.size()) << noise;
    for (std::size_t i = 0; i < motion.size(); ++i) {
      EXPECT_EQ(screened.samples[i].gyro, motion[i].gyro);
      EXPECT_FALSE(HasDoubt(screened.samples[i])) << noise << " " << i;
    }
    EXPECT_EQ(
        screened.counts.num_cut + screened.counts.num_saturated + screened.counts.num_repeated, 0);
  }
}

// What a bus delivers on a bad day, of each size that the reports of users mention.
TEST(ImuScreenTest, ASingleGlitchIsCutOut) {
  const std::vector<ImuSample> motion = Motion(1000);
  struct Glitch {
    Vector3d gyro, accel;
  };
  const std::vector<Glitch> glitches = {{{0.8, 0, 0}, {0, 0, 0}},
                                        {{0, 5, 0}, {0, 0, 0}},
                                        {{35, 0, 0}, {0, 0, 0}},
                                        {{0, 0, -100}, {0, 0, 0}},
                                        {{0, 0, 0}, {12, 0, 0}},
                                        {{0, 0, 0}, {0, 160, 0}},
                                        {{30000, 30000, 30000}, {30000, 30000, 30000}}};
  for (const Glitch& glitch : glitches) {
    for (const std::size_t at : {std::size_t{500}, std::size_t{501}, std::size_t{730}}) {
      std::vector<ImuSample> spoilt = motion;
      spoilt[at].gyro += glitch.gyro;
      spoilt[at].accel += glitch.accel;
      const Screened screened = Screen(spoilt);
      EXPECT_EQ(screened.counts.num_cut, 1);
      ASSERT_EQ(screened.samples.size(), motion.size() - 1);
      EXPECT_EQ(screened.samples[at - 1].gyro, motion[at - 1].gyro);
      EXPECT_EQ(screened.samples[at].t, motion[at + 1].t);
    }
  }
}

TEST(ImuScreenTest, SoAreAFewInARowAndTheFirstOne) {
  const std::vector<ImuSample> motion = Motion(600);
  std::vector<ImuSample> spoilt = motion;
  for (const std::size_t i : {300u, 301u, 302u})
    spoilt[i].gyro.x() = 17;
  EXPECT_EQ(Screen(spoilt).counts.num_cut, 3);

  spoilt = motion;
  spoilt[300].gyro.x() = 35;
  spoilt[301].gyro.y() = -35;  // nothing in common with the one before
  EXPECT_EQ(Screen(spoilt).samples.size(), motion.size() - 2);

  spoilt = motion;
  spoilt[0].gyro.x() = 100;
  const Screened screened = Screen(spoilt);
  EXPECT_EQ(screened.counts.num_cut, 1);
  EXPECT_EQ(screened.samples.front().t, motion[1].t);
}

// However long: nothing that moves measures the same number again and again.
TEST(ImuScreenTest, AGlitchThatStandsStillIsCutOut) {
  const std::vector<ImuSample> motion = Motion(1200);
  for (const std::size_t count : {4u, 6u, 12u, 40u}) {
    std::vector<ImuSample> of_gyro = motion, of_accel = motion;
    for (std::size_t i = 600; i < 600 + count; ++i) {
      of_gyro[i].gyro.x() = 20;
      of_accel[i].accel.y() = 160;
    }
    for (const auto& spoilt : {of_gyro, of_accel}) {
      const Screened screened = Screen(spoilt);
      EXPECT_EQ(screened.counts.num_cut, static_cast<int>(count));
      EXPECT_EQ(screened.counts.num_saturated, 0) << count;
      ASSERT_EQ(screened.samples.size(), motion.size() - count);
      EXPECT_EQ(screened.samples[600].t, motion[600 + count].t);
    }
  }
}

TEST(ImuScreenTest, OneSensorThatDiesIsDoubtedAlone) {
  std::vector<ImuSample> motion = Motion(1200);
  for (std::size_t i = 600; i < 800; ++i)
    motion[i].accel = Vector3d(0.01, 0, 0);
  const Screened screened = Screen(motion);
  ASSERT_EQ(screened.samples.size(), motion.size());
  EXPECT_NEAR(screened.counts.num_repeated, 190, 3);
  double variance = 0;
  for (const ImuSample& sample : screened.samples) {
    EXPECT_TRUE(sample.gyro_doubt.isZero(0));
    variance += sample.accel_doubt.x() * sample.accel_doubt.x();
  }
  // As if gravity had been missed in all of the stay.
  EXPECT_NEAR(std::sqrt(variance), 199 * kGravity, 0.01 * 199 * kGravity);
}

TEST(ImuScreenTest, AnAxisThatIsStuckIsDoubtedAlone) {
  for (const int axis : {0, 1, 2}) {
    std::vector<ImuSample> motion = Motion(1200);
    for (std::size_t i = 600; i < 800; ++i)
      motion[i].gyro[axis] = motion[599].gyro[axis];
    const Screened screened = Screen(motion);
    ASSERT_EQ(screened.samples.size(), motion.size());
    EXPECT_NEAR(screened.counts.num_repeated, 182, 8);
    Vector3d variance = Vector3d::Zero();
    for (const ImuSample& sample : screened.samples) {
      EXPECT_TRUE(sample.accel_doubt.isZero(0));
      variance += sample.gyro_doubt.cwiseAbs2();
    }
    const Vector3d expected = 200 * 0.3 * Vector3d::Unit(axis);
    EXPECT_LT((variance.cwiseSqrt() - expected).norm(), 0.5) << variance.transpose();
  }
}

// At rest values repeat themselves for long, some more than others: it depends on where the mean
// lies between two digits.
TEST(ImuScreenTest, ACoarseSensorIsNotStuck) {
  constexpr double kGyroDigit = 4.8e-3, kAccelDigit = 0.056;
  for (const double noise : {0.1, 0.15, 0.25, 0.5}) {  // in digits
    std::vector<ImuSample> samples = Motion(8000, noise * kGyroDigit, noise * kAccelDigit);
    Rng rng(4);
    for (std::size_t i = 4000; i < samples.size(); ++i) {
      samples[i].gyro = kGyroDigit * (Vector3d(0, 0.3, 0.5) + noise * rng.Normal3());
      samples[i].accel = kAccelDigit * (Vector3d(0.5, 0, 175.2) + noise * rng.Normal3());
    }
    for (ImuSample& sample : samples) {
      sample.gyro = (sample.gyro / kGyroDigit).array().round() * kGyroDigit;
      sample.accel = (sample.accel / kAccelDigit).array().round() * kAccelDigit;
    }
    const Screened screened = Screen(samples);
    int num_stuck = 0;
    for (const ImuSample& sample : screened.samples) {
      if (sample.t < StampOf(4000)) continue;
      // All of a sensor at once is another matter.
      for (const Vector3d& doubt : {sample.gyro_doubt, sample.accel_doubt})
        num_stuck += doubt.maxCoeff() > 0 && doubt.minCoeff() == 0 ? 1 : 0;
    }
    EXPECT_EQ(num_stuck, 0) << noise;
    EXPECT_EQ(screened.counts.num_cut, 0) << noise;
  }
}

// Somebody puts it down: at 50 Hz that is one sample.
TEST(ImuScreenTest, ASlowSensorMayFeelABump) {
  std::vector<ImuSample> slow;
  const std::vector<ImuSample> motion = Motion(8000);
  for (std::size_t i = 0; i < motion.size(); i += 4) {
    slow.push_back(motion[i]);
    slow.back().gyro = Vector3d::Zero() + 2.4e-3 * motion[i].gyro;
    slow.back().accel = Vector3d(0, 0, 9.8) + 0.028 * motion[i].accel;
    if (i % 400 == 200) slow.back().accel.z() += 6;
  }
  EXPECT_EQ(Screen(slow).counts.num_cut, 0);
}

// Below what no motion does, but far beyond what this sensor has shown.
TEST(ImuScreenTest, SmallGlitchesOfAQuietSensorAreCutOut) {
  std::vector<ImuSample> motion = Motion(4000);
  int num_glitches = 0;
  for (std::size_t i = 500; i + 50 < motion.size(); i += 50, ++num_glitches) {
    if (num_glitches % 2 == 0) {
      motion[i].accel.y() += 8.9;
    } else {
      motion[i].gyro.z() -= 0.5;
    }
  }
  EXPECT_EQ(Screen(motion).counts.num_cut, num_glitches);
}

// Drivers that join a slow accelerometer with a fast gyroscope send its samples again.
TEST(ImuScreenTest, ASlowSensorThatIsSentAgainIsNotDoubted) {
  std::vector<ImuSample> motion = Motion(1200);
  for (std::size_t i = 0; i < motion.size(); ++i)
    motion[i].accel = motion[i - i % 6].accel;
  const Screened screened = Screen(motion);
  EXPECT_EQ(screened.counts.num_repeated, 0);
  for (const ImuSample& sample : screened.samples)
    EXPECT_FALSE(HasDoubt(sample));
}

TEST(ImuScreenTest, AJumpThatLastsIsBelieved) {
  std::vector<ImuSample> motion = Motion(600);
  for (std::size_t i = 300; i < motion.size(); ++i)
    motion[i].accel.z() += 80;  // a launch
  const Screened screened = Screen(motion);
  EXPECT_EQ(screened.samples.size(), motion.size());
  EXPECT_EQ(screened.counts.num_cut, 0);
}

TEST(ImuScreenTest, TheEndOfTheRangeIsNoticed) {
  std::vector<ImuSample> motion = Motion(4000);
  int num_clipped = 0;
  for (ImuSample& sample : motion) {
    num_clipped += std::abs(sample.gyro.x()) > 0.6 ? 1 : 0;
    sample.gyro.x() = std::clamp(sample.gyro.x(), -0.6, 0.5995);
  }
  const Screened screened = Screen(motion);
  EXPECT_EQ(screened.counts.num_cut, 0);
  EXPECT_GT(screened.counts.num_saturated, 0.95 * num_clipped);
  EXPECT_LE(screened.counts.num_saturated, num_clipped + 5);
  double variance = 0;
  for (const ImuSample& sample : screened.samples) {
    if (sample.gyro_doubt.x() > 0) {
      EXPECT_GE(std::abs(sample.gyro.x()), 0.599);
    }
    EXPECT_EQ(sample.gyro_doubt.y(), 0);
    EXPECT_TRUE(sample.accel_doubt.isZero(0));
    variance += sample.gyro_doubt.squaredNorm();
  }
  EXPECT_GT(variance, 0);
}

// A turn of 2 s whose top is cut off: the doubt covers the angle that is missing.
TEST(ImuScreenTest, TheDoubtOfAStayCoversWhatIsMissing) {
  Rng rng(1);
  std::vector<ImuSample> motion;
  double missing = 0;
  for (int i = 0; i < 800; ++i) {
    const double rate = std::sin(std::numbers::pi * i * kStep_s / 2);
    ImuSample sample{StampOf(i), Vector3d(rate, 0, 0), Vector3d(0, 0, 9.81)};
    sample.gyro += 2e-3 * rng.Normal3();
    sample.gyro.x() = std::clamp(sample.gyro.x(), -0.6, 0.6);
    if (rate > 0.6) missing += (rate - 0.6) * kStep_s;
    motion.push_back(sample);
  }
  double variance = 0;
  for (const ImuSample& sample : Screen(motion).samples) {
    if (sample.gyro.x() > 0) variance += std::pow(sample.gyro_doubt.x() * kStep_s, 2);
  }
  EXPECT_GT(std::sqrt(variance), missing / 2.5);
  EXPECT_LT(std::sqrt(variance), missing * 2.5);
}

TEST(ImuScreenTest, ATurningPointIsNoEndOfARange) {
  // A sensor almost without noise and with coarse digits stands still where its motion turns.
  std::vector<ImuSample> motion = Motion(4000, 1e-5, 1e-4);
  for (ImuSample& sample : motion) {
    for (int i = 0; i < 3; ++i) {
      sample.gyro[i] = 0.001 * std::round(sample.gyro[i] / 0.001);
      sample.accel[i] = 0.005 * std::round(sample.accel[i] / 0.005);
    }
  }
  EXPECT_EQ(Screen(motion).counts.num_saturated, 0);
}

TEST(ImuScreenTest, ASensorThatRepeatsItselfIsDoubtedMoreAndMore) {
  std::vector<ImuSample> motion = Motion(1000);
  for (int i = 501; i < 560; ++i) {
    motion[i] = motion[500];
    motion[i].t = StampOf(i);
  }
  const Screened screened = Screen(motion);
  EXPECT_EQ(screened.samples.size(), motion.size());
  EXPECT_EQ(screened.counts.num_repeated, 59 - 2);
  EXPECT_FALSE(HasDoubt(screened.samples[500]));
  EXPECT_FALSE(HasDoubt(screened.samples[560]));
  double variance = 0;
  for (const ImuSample& sample : screened.samples)
    variance += std::pow(sample.gyro_doubt.x() * kStep_s, 2);
  EXPECT_NEAR(std::sqrt(variance), 0.3 * 59 * kStep_s, 0.01);
}

TEST(ImuScreenTest, RestWithoutNoiseIsNoFault) {
  std::vector<ImuSample> rest;
  for (int i = 0; i < 500; ++i)
    rest.push_back({StampOf(i), Vector3d::Zero(), Vector3d(0, 0, 9.81)});
  const Screened screened = Screen(rest);
  EXPECT_EQ(screened.samples.size(), rest.size());
  EXPECT_EQ(screened.counts.num_repeated, 0);
  EXPECT_EQ(screened.counts.num_saturated, 0);
}

// Propellers at half the rate of the samples: every other sample is on the other side, from the
// first one on or swelling after rest. The size is that of EuRoC's V1_01 at the take-off.
TEST(ImuScreenTest, AVibrationAtHalfTheRateIsMotion) {
  for (const int begin : {0, 15, 400}) {
    std::vector<ImuSample> motion = Motion(1000);
    for (int i = begin; i < 1000; ++i) {
      const double swell = begin == 0 ? 1 : std::min(1.0, 0.1 * (i - begin));
      motion[static_cast<std::size_t>(i)].accel.x() += (i % 2 == 0 ? 5 : -5) * swell;
    }
    const Screened screened = Screen(motion);
    EXPECT_EQ(screened.counts.num_cut, 0) << begin;
    EXPECT_EQ(screened.samples.size(), motion.size()) << begin;
  }
}

TEST(ImuScreenTest, SlowAndFastSensorsPass) {
  for (const int keep_every : {2, 5, 10}) {  // 100, 40 and 20 Hz
    std::vector<ImuSample> slow;
    const std::vector<ImuSample> motion = Motion(8000);
    for (std::size_t i = 0; i < motion.size(); i += static_cast<std::size_t>(keep_every))
      slow.push_back(motion[i]);
    const Screened screened = Screen(slow);
    EXPECT_EQ(screened.counts.num_cut, 0) << keep_every;
    EXPECT_EQ(screened.samples.size(), slow.size());
  }
}

}  // namespace
}  // namespace facet
