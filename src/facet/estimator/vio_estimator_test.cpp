// SPDX-License-Identifier: BSD-2-Clause
// Bad input must never throw, and a good recording must go on after it.
#include "facet/estimator/vio_estimator.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"

namespace facet {
namespace {

const SimulatedRun& TheRun() {
  static const SimulatedRun run = [] {
    FeatureSimulatorOptions options;
    options.max_tracks = 70;
    options.duration_s = 8;
    StereoRig rig = EurocRig();
    // Camera and IMU clocks differ by more than a frame.
    rig.time_offset = Duration{70'000'000};
    return SimulateFeatures(SplineTrajectory::Fit(MakeFlight(10, 2)), rig, options, 1);
  }();
  return run;
}

struct Input {
  FrameObservations observations;
  ImuInterval imu;
};
using Spoil = std::function<void(std::size_t i, Input& input)>;

struct Outcome {
  std::vector<EstimatorResult> results;
  int num_resets = 0;
};

Outcome Estimate(const Spoil& spoil, const EstimatorOptions& options = {}) {
  const SimulatedRun& run = TheRun();
  ImuBuffer buffer;
  for (const ImuSample& sample : run.imu)
    buffer.Add(sample);
  VioEstimator estimator(run.rig, ImuNoise{}, options);
  StageTimes times;
  Outcome outcome;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    Input input{run.frames[i], {}};
    if (i > 0) {
      input.imu =
          buffer.Between(run.truth[i - 1].t, run.truth[i].t, Duration{20'000'000}, Duration{0});
    }
    spoil(i, input);
    outcome.results.push_back(estimator.AddFrame(input.observations, input.imu, times));
    outcome.num_resets += outcome.results.back().was_reset;
    EXPECT_NO_THROW(estimator.Snapshot());
  }
  return outcome;
}

// Distance moved since frame `from` by the estimate against the truth.
double MotionError(const Outcome& outcome, std::size_t from, std::size_t to) {
  const SimulatedRun& run = TheRun();
  const SE3 T_est = outcome.results[from].state.T_WB.Inverse() * outcome.results[to].state.T_WB;
  const SE3 T_true = run.truth[from].T_WB.Inverse() * run.truth[to].T_WB;
  return (T_est.p - T_true.p).norm();
}

bool IsFinite(const EstimatorResult& r) {
  return r.state.T_WB.p.allFinite() && r.state.T_WB.q.coeffs().allFinite() &&
         r.state.v_WB.allFinite() && r.state.bias.b_g.allFinite() && r.state.bias.b_a.allFinite() &&
         r.covariance.allFinite();
}

// Runs to the end, is finite wherever it claims to have a state, and is well again over the last
// second.
void ExpectRecovers(const Outcome& outcome, double max_error) {
  const std::size_t last = outcome.results.size() - 1;
  for (const EstimatorResult& result : outcome.results) {
    EXPECT_TRUE(!result.has_state || IsFinite(result));
  }
  ASSERT_TRUE(outcome.results[last - 20].has_state && outcome.results[last].has_state);
  EXPECT_EQ(outcome.results[last].status, TrackingStatus::kOk) << outcome.results[last].reason;
  EXPECT_LT(MotionError(outcome, last - 20, last), max_error);
}

constexpr std::size_t kBegin = 80, kEnd = 100;  // frames 4 s to 5 s are spoilt
bool InBadSecond(std::size_t i) {
  return i >= kBegin && i < kEnd;
}

TEST(VioEstimatorTest, TracksAGoodRecording) {
  const Outcome outcome = Estimate([](std::size_t, Input&) {});
  std::size_t first = 0;
  while (!outcome.results[first].has_state)
    ++first;
  EXPECT_LE(first, 9u);  // 0.45 s
  EXPECT_EQ(outcome.num_resets, 0);
  for (std::size_t i = first; i < outcome.results.size(); ++i) {
    EXPECT_EQ(outcome.results[i].status, TrackingStatus::kOk)
        << i << ": " << outcome.results[i].reason;
  }
  ExpectRecovers(outcome, 0.02);
  EXPECT_LT(MotionError(outcome, first, outcome.results.size() - 1), 0.1);
}

// Seconds from the first frame to the first pose, with a camera of this rate.
double SecondsToStart(bool is_at_rest, double frame_rate_hz) {
  FeatureSimulatorOptions options;
  options.frame_rate_hz = frame_rate_hz;
  options.max_tracks = 70;
  options.duration_s = 4;
  std::vector<NavState> poses = MakeFlight(10, 2);
  if (is_at_rest) {
    for (NavState& pose : poses)
      pose.T_WB = poses.front().T_WB;
  }
  const SimulatedRun run = SimulateFeatures(SplineTrajectory::Fit(poses), EurocRig(), options, 1);
  ImuBuffer buffer;
  for (const ImuSample& sample : run.imu)
    buffer.Add(sample);
  VioEstimator estimator(run.rig, ImuNoise{}, {});
  StageTimes times;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    ImuInterval imu;
    if (i > 0) {
      imu = buffer.Between(run.truth[i - 1].t, run.truth[i].t, Duration{20'000'000}, {});
    }
    if (estimator.AddFrame(run.frames[i], imu, times).has_state)
      return ToSeconds(run.frames[i].t - run.frames[0].t);
  }
  return std::numeric_limits<double>::infinity();
}

TEST(VioEstimatorTest, ASlowCameraStartsNearlyAsSoon) {
  for (const bool is_at_rest : {false, true}) {
    EXPECT_NEAR(SecondsToStart(is_at_rest, 20), 0.3, 1e-6);
    EXPECT_NEAR(SecondsToStart(is_at_rest, 15), 0.333, 0.001);
    EXPECT_NEAR(SecondsToStart(is_at_rest, 10), 0.3, 1e-6);
    EXPECT_NEAR(SecondsToStart(is_at_rest, 5), 0.6, 1e-6);
  }
}

TEST(VioEstimatorTest, TheSameInputGivesTheSameBits) {
  const Outcome a = Estimate([](std::size_t, Input&) {});
  const Outcome b = Estimate([](std::size_t, Input&) {});
  for (std::size_t i = 0; i < a.results.size(); ++i) {
    const NavState& x = a.results[i].state;
    const NavState& y = b.results[i].state;
    ASSERT_EQ(x.T_WB.p, y.T_WB.p) << i;
    ASSERT_EQ(x.T_WB.q.coeffs(), y.T_WB.q.coeffs()) << i;
    ASSERT_EQ(x.v_WB, y.v_WB) << i;
    ASSERT_EQ(x.bias.b_a, y.bias.b_a) << i;
    ASSERT_EQ(a.results[i].covariance, b.results[i].covariance) << i;
  }
}

TEST(VioEstimatorTest, SurvivesASecondOfDarkness) {
  const Outcome outcome = Estimate([](std::size_t i, Input& input) {
    if (InBadSecond(i)) input.observations.features.clear();
  });
  ExpectRecovers(outcome, 0.1);
  EXPECT_EQ(outcome.num_resets, 0);
  for (std::size_t i = kBegin; i < kEnd; ++i)
    EXPECT_EQ(outcome.results[i].status, TrackingStatus::kDegraded) << i;
  // The IMU carried it through.
  EXPECT_LT(MotionError(outcome, kBegin - 1, kEnd + 10), 0.5);
}

TEST(VioEstimatorTest, SurvivesDarknessDuringTheStart) {
  const Outcome outcome = Estimate([](std::size_t i, Input& input) {
    if (i >= 3 && i < 23) input.observations.features.clear();
  });
  ExpectRecovers(outcome, 0.1);
}

// Neither invented samples nor dark frames are something to start from.
TEST(VioEstimatorTest, StartsWhenImuAndLightAreThere) {
  constexpr std::size_t kFirstGood = 20;
  const Outcome without_imu = Estimate([](std::size_t i, Input& input) {
    if (i <= kFirstGood) input.imu = {};
  });
  const Outcome in_the_dark = Estimate([](std::size_t i, Input& input) {
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

TEST(VioEstimatorTest, NeverSeesAnything) {
  const Outcome outcome =
      Estimate([](std::size_t, Input& input) { input.observations.features.clear(); });
  for (const EstimatorResult& result : outcome.results) {
    EXPECT_FALSE(result.has_state);
    EXPECT_EQ(result.status, TrackingStatus::kInitialising);
    EXPECT_FALSE(result.reason.empty());
  }
}

TEST(VioEstimatorTest, SurvivesPixelsThatAreNotNumbers) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const Outcome outcome = Estimate([&](std::size_t i, Input& input) {
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

TEST(VioEstimatorTest, SurvivesSigmasThatMakeNoSense) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const Outcome outcome = Estimate([&](std::size_t i, Input& input) {
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

TEST(VioEstimatorTest, SurvivesAbsurdlySmallSigmas) {
  const Outcome outcome = Estimate([&](std::size_t i, Input& input) {
    if (InBadSecond(i)) {
      for (FeatureObservation& f : input.observations.features)
        f.sigma_left_px = f.sigma_right_px = 1e-200;
    }
  });
  for (const EstimatorResult& result : outcome.results) {
    EXPECT_TRUE(!result.has_state || IsFinite(result));
  }
}

TEST(VioEstimatorTest, UsesALandmarkOncePerFrame) {
  const Outcome outcome = Estimate([](std::size_t, Input& input) {
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

TEST(VioEstimatorTest, SurvivesAMissingImuInterval) {
  for (const std::size_t step : {0, 1}) {
    const Outcome outcome = Estimate([&](std::size_t i, Input& input) {
      // One interval, or a whole second.
      if (i == kBegin || (step == 1 && InBadSecond(i))) input.imu = ImuInterval{};
    });
    ExpectRecovers(outcome, 0.1);
  }
}

TEST(VioEstimatorTest, SurvivesMissingImuDuringTheStart) {
  const Outcome outcome = Estimate([&](std::size_t i, Input& input) {
    if (i == 4) input.imu = ImuInterval{};
  });
  ExpectRecovers(outcome, 0.1);
}

TEST(VioEstimatorTest, SurvivesAHoleInTheImu) {
  const Outcome outcome = Estimate([&](std::size_t i, Input& input) {
    if (i != kBegin && i != kBegin + 2) return;
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
TEST(VioEstimatorTest, RefusesAFrameWithTheSameStamp) {
  for (const std::size_t num_samples : {1, 2}) {
    for (const std::size_t at : {std::size_t{3}, kBegin, kBegin + 1}) {
      ImuInterval before;
      const Outcome outcome = Estimate([&](std::size_t i, Input& input) {
        if (i == at) {
          before = input.imu;
          input.observations.t = TheRun().frames[i - 1].t;
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

TEST(VioEstimatorTest, SurvivesImuIntervalsThatMakeNoSense) {
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
    for (const std::size_t at : {std::size_t{3}, kBegin, kBegin + 1}) {
      const Outcome outcome = Estimate([&](std::size_t i, Input& input) {
        if (i == at) spoil(input.imu.samples);
      });
      ExpectRecovers(outcome, 0.1);
    }
  }
}

TEST(VioEstimatorTest, RefusesAFrameFromThePast) {
  for (const std::size_t at : {std::size_t{3}, kBegin, kBegin + 1}) {
    const Outcome outcome = Estimate([&](std::size_t i, Input& input) {
      if (i != at) return;
      input.observations.t = input.observations.t - Duration{200'000'000};
      input.imu = ImuInterval{};
    });
    ExpectRecovers(outcome, 0.1);
  }
}

TEST(VioEstimatorTest, SurvivesWrongAssociations) {
  const Outcome outcome = Estimate([&](std::size_t i, Input& input) {
    auto& features = input.observations.features;
    if (!InBadSecond(i)) return;
    // All ids moved on by one: nothing fits.
    for (std::size_t k = 0; k + 1 < features.size(); ++k)
      std::swap(features[k].landmark, features[k + 1].landmark);
  });
  for (const EstimatorResult& result : outcome.results) {
    EXPECT_TRUE(!result.has_state || IsFinite(result));
  }
  EXPECT_TRUE(outcome.results.back().has_state);
}

TEST(VioEstimatorTest, EveryFrameAKeyframeOrNoneAfterTheStart) {
  for (const bool keyframe : {false, true}) {
    const Outcome outcome = Estimate([&](std::size_t i, Input& input) {
      if (keyframe || i > 30) input.observations.is_keyframe = keyframe;
    });
    for (const EstimatorResult& result : outcome.results) {
      EXPECT_TRUE(!result.has_state || IsFinite(result));
    }
    EXPECT_TRUE(outcome.results.back().has_state || !keyframe);
  }
}

TEST(VioEstimatorTest, WindowStaysWithinItsLimits) {
  const SimulatedRun& run = TheRun();
  ImuBuffer buffer;
  for (const ImuSample& sample : run.imu)
    buffer.Add(sample);
  EstimatorOptions options;
  VioEstimator estimator(run.rig, ImuNoise{}, options);
  StageTimes times;
  std::size_t num_finished = 0;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    ImuInterval imu;
    if (i > 0)
      imu = buffer.Between(run.truth[i - 1].t, run.truth[i].t, Duration{20'000'000}, Duration{0});
    num_finished += estimator.AddFrame(run.frames[i], imu, times).finished_keyframes.size();
    EXPECT_LE(static_cast<int>(estimator.window().frames.size()),
              std::max(options.window.max_start_keyframes + 12,
                       options.window.max_full_keyframes + options.window.max_pose_keyframes));
  }
  int num_full = 0;
  for (const WindowFrame& frame : estimator.window().frames)
    num_full += frame.has_motion;
  EXPECT_EQ(num_full, options.window.max_full_keyframes);
  EXPECT_EQ(static_cast<int>(estimator.window().frames.size()) - num_full,
            options.window.max_pose_keyframes);
  EXPECT_GT(num_finished, 10u);
}

}  // namespace
}  // namespace facet
