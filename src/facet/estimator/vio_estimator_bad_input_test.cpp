// SPDX-License-Identifier: BSD-2-Clause
// Bad input must never throw, and a good recording must go on after it.
#include <algorithm>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "facet/testing/estimator/spoilt_run.h"

namespace facet {
namespace {

using testing::Estimate;
using testing::EstimatorInput;
using testing::ExpectRecovers;
using testing::IsFinite;
using testing::MotionError;
using testing::Outcome;

TEST(VioEstimatorBadInputTest, SurvivesASecondOfDarkness) {
  const Outcome outcome = Estimate([](std::size_t i, EstimatorInput& input) {
    if (testing::InBadSecond(i)) input.observations.features.clear();
  });
  ExpectRecovers(outcome, 0.1);
  EXPECT_EQ(outcome.num_resets, 0);
  for (std::size_t i = testing::kBadBegin; i < testing::kBadEnd; ++i)
    EXPECT_EQ(outcome.results[i].status, TrackingStatus::kDegraded) << i;
  // The IMU carried it through.
  EXPECT_LT(MotionError(outcome, testing::kBadBegin - 1, testing::kBadEnd + 10), 0.5);
}

TEST(VioEstimatorBadInputTest, SurvivesDarknessDuringTheStart) {
  const Outcome outcome = Estimate([](std::size_t i, EstimatorInput& input) {
    if (i >= 3 && i < 23) input.observations.features.clear();
  });
  ExpectRecovers(outcome, 0.1);
}

// Neither invented samples nor dark frames are something to start from.
TEST(VioEstimatorBadInputTest, StartsWhenImuAndLightAreThere) {
  constexpr std::size_t kFirstGood = 20;
  const Outcome without_imu = Estimate([](std::size_t i, EstimatorInput& input) {
    if (i <= kFirstGood) input.imu = {};
  });
  const Outcome in_the_dark = Estimate([](std::size_t i, EstimatorInput& input) {
    if (i < kFirstGood) input.observations.features.clear();
  });
  for (const Outcome* outcome : {&without_imu, &in_the_dark}) {
    std::size_t first = 0;
    while (!outcome->results[first].has_state)
      ++first;
    EXPECT_GE(first, kFirstGood + 6);
    EXPECT_LE(first, kFirstGood + 10);
    EXPECT_EQ(outcome->num_resets, 0);
    EXPECT_LT(MotionError(*outcome, first, outcome->results.size() - 1), 0.05);
  }
  EXPECT_EQ(without_imu.results[10].reason, "no IMU");
}

TEST(VioEstimatorBadInputTest, NeverSeesAnything) {
  const Outcome outcome =
      Estimate([](std::size_t, EstimatorInput& input) { input.observations.features.clear(); });
  for (const EstimatorResult& result : outcome.results) {
    EXPECT_FALSE(result.has_state);
    EXPECT_EQ(result.status, TrackingStatus::kInitialising);
    EXPECT_FALSE(result.reason.empty());
  }
}

TEST(VioEstimatorBadInputTest, SurvivesPixelsThatAreNotNumbers) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
    for (std::size_t k = 0; k < input.observations.features.size(); ++k) {
      FeatureObservation& feature = input.observations.features[k];
      if ((i + k) % 10 == 0) feature.px_left.x() = kNan;
      if ((i + k) % 10 == 1 && feature.px_right) feature.px_right->y() = kNan;
      if ((i + k) % 10 == 2) feature.px_left = Vector2d(1e300, -1e300);
      if ((i + k) % 10 == 3 && feature.px_right)
        feature.px_right->x() = std::numeric_limits<double>::infinity();
    }
  });
  ExpectRecovers(outcome, 0.03);
  EXPECT_EQ(outcome.num_resets, 0);
}

TEST(VioEstimatorBadInputTest, SurvivesSigmasThatMakeNoSense) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
    for (std::size_t k = 0; k < input.observations.features.size(); ++k) {
      FeatureObservation& feature = input.observations.features[k];
      if ((i + k) % 10 == 0) feature.sigma_left_px = 0;
      if ((i + k) % 10 == 1) feature.sigma_left_px = -1;
      if ((i + k) % 10 == 2) feature.sigma_right_px = 0;
      if ((i + k) % 10 == 3) feature.sigma_right_px = kNan;
      if ((i + k) % 10 == 4) feature.sigma_left_px = kNan;
      if ((i + k) % 10 == 5) feature.sigma_left_px = std::numeric_limits<double>::infinity();
    }
  });
  ExpectRecovers(outcome, 0.05);
  EXPECT_EQ(outcome.num_resets, 0);
}

TEST(VioEstimatorBadInputTest, SurvivesAbsurdlySmallSigmas) {
  const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
    if (testing::InBadSecond(i)) {
      for (FeatureObservation& f : input.observations.features)
        f.sigma_left_px = f.sigma_right_px = 1e-200;
    }
  });
  for (const EstimatorResult& result : outcome.results) {
    EXPECT_TRUE(!result.has_state || IsFinite(result));
  }
}

TEST(VioEstimatorBadInputTest, UsesALandmarkOncePerFrame) {
  const Outcome outcome = Estimate([](std::size_t, EstimatorInput& input) {
    std::vector<FeatureObservation>& features = input.observations.features;
    const std::size_t n = features.size();
    for (std::size_t k = 0; k < n; k += 3) {
      features.push_back(features[k]);
      features.back().px_left += Vector2d(30, 30);
    }
  });
  ExpectRecovers(outcome, 0.03);
  EXPECT_EQ(outcome.num_resets, 0);
}

TEST(VioEstimatorBadInputTest, SurvivesAMissingImuInterval) {
  for (const std::size_t step : {0, 1}) {
    const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
      // One interval, or a whole second.
      if (i == testing::kBadBegin || (step == 1 && testing::InBadSecond(i)))
        input.imu = ImuInterval{};
    });
    ExpectRecovers(outcome, 0.1);
  }
}

TEST(VioEstimatorBadInputTest, SurvivesMissingImuDuringTheStart) {
  const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
    if (i == 4) input.imu = ImuInterval{};
  });
  ExpectRecovers(outcome, 0.1);
}

TEST(VioEstimatorBadInputTest, SurvivesAHoleInTheImu) {
  const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
    if (i != testing::kBadBegin && i != testing::kBadBegin + 2) return;
    auto& samples = input.imu.samples;
    samples.erase(samples.begin() + 1, samples.end() - 1);
    input.imu.gaps = 1;
    input.imu.longest_gap = samples.back().t - samples.front().t;
    input.imu.has_hole = true;
  });
  ExpectRecovers(outcome, 0.05);
  EXPECT_EQ(outcome.num_resets, 0);
}

// Two frames with the same stamp, an interval of one sample or of two with the same stamp. The
// second frame is refused; the next interval begins where the first one ended.
TEST(VioEstimatorBadInputTest, RefusesAFrameWithTheSameStamp) {
  for (const std::size_t num_samples : {1, 2}) {
    for (const std::size_t at : {std::size_t{3}, testing::kBadBegin, testing::kBadBegin + 1}) {
      ImuInterval before;
      const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
        if (i == at) {
          before = input.imu;
          input.observations.t = testing::SpoiltRun().frames[i - 1].t;
          input.imu.samples.assign(num_samples, before.samples.front());
        } else if (i == at + 1) {
          before.samples.insert(
              before.samples.end(), input.imu.samples.begin() + 1, input.imu.samples.end());
          input.imu = before;
        }
      });
      ExpectRecovers(outcome, 0.03);
      EXPECT_EQ(outcome.num_resets, 0);
      EXPECT_FALSE(outcome.results[at].has_state);
      EXPECT_NE(outcome.results[at].reason.find("stamp"), std::string::npos);
    }
  }
}

TEST(VioEstimatorBadInputTest, SurvivesImuIntervalsThatMakeNoSense) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::function<void(std::vector<ImuSample>&)>> mischief = {
      [](auto& samples) { std::reverse(samples.begin(), samples.end()); },
      [](auto& samples) { std::swap(samples[3], samples[4]); },
      [](auto& samples) { samples.erase(samples.begin()); },  // begins too late
      [](auto& samples) { samples[2].gyro.x() = kNan; },
      [](auto& samples) { samples[2].accel.z() = std::numeric_limits<double>::infinity(); },
      [](auto& samples) { samples.back().t.ns += 3'600'000'000'000; },
  };
  for (const auto& spoil : mischief) {
    for (const std::size_t at : {std::size_t{3}, testing::kBadBegin, testing::kBadBegin + 1}) {
      const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
        if (i == at) spoil(input.imu.samples);
      });
      ExpectRecovers(outcome, 0.1);
    }
  }
}

TEST(VioEstimatorBadInputTest, RefusesAFrameFromThePast) {
  for (const std::size_t at : {std::size_t{3}, testing::kBadBegin, testing::kBadBegin + 1}) {
    const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
      if (i != at) return;
      input.observations.t = input.observations.t - Duration{200'000'000};
      input.imu = ImuInterval{};
    });
    ExpectRecovers(outcome, 0.1);
  }
}

TEST(VioEstimatorBadInputTest, SurvivesWrongAssociations) {
  const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
    auto& features = input.observations.features;
    if (!testing::InBadSecond(i)) return;
    // All ids moved on by one: nothing fits.
    for (std::size_t k = 0; k + 1 < features.size(); ++k)
      std::swap(features[k].landmark, features[k + 1].landmark);
  });
  for (const EstimatorResult& result : outcome.results) {
    EXPECT_TRUE(!result.has_state || IsFinite(result));
  }
  EXPECT_TRUE(outcome.results.back().has_state);
}

}  // namespace
}  // namespace facet
