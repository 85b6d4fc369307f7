// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/vio_estimator.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include <gtest/gtest.h>

#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/estimator/spoilt_run.h"

namespace facet {
namespace {

using testing::Estimate;
using testing::EstimatorInput;
using testing::ExpectRecovers;
using testing::IsFinite;
using testing::MotionError;
using testing::Outcome;

TEST(VioEstimatorTest, TracksAGoodRecording) {
  const Outcome outcome = Estimate([](std::size_t, EstimatorInput&) {});
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
  const ImuBuffer imu = testing::ImuOf(run);
  VioEstimator estimator(run.rig, ImuNoise{}, {});
  StageTimes times;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const EstimatorInput input = testing::InputOf(run, imu, i);
    if (estimator.AddFrame(input.observations, input.imu, times).has_state)
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

// A wall of many points, 1.3 m wide, that passes 1.2 m in front of the cameras.
class PassingWall {
 public:
  static constexpr std::size_t kBegin = 60;

  explicit PassingWall(std::uint64_t seed) : rng_(seed) {
    for (int k = 0; k < kNumPoints; ++k)
      points_.push_back({rng_.Uniform(-2.5, -1.2), rng_.Uniform(-0.8, 0.8), 1.2});
  }

  // It hides what is behind it.
  void Cover(std::size_t i, FrameObservations& observations) {
    if (i < kBegin) return;
    const SimulatedRun& run = testing::SpoiltRun();
    const SE3 T_WC = run.truth[kBegin].T_WB * run.rig.T_BC[0];
    const SE3 T_BW = run.truth[i].T_WB.Inverse();
    const Vector3d moved(kSpeed * ToSeconds(run.frames[i].t - run.frames[kBegin].t), 0, 0);
    std::vector<FeatureObservation> seen;
    double begin_px = 1e9, end_px = -1e9;
    for (int k = 0; k < kNumPoints; ++k) {
      const auto px = Pixels(run.rig, T_BW * (T_WC * (points_[k] + moved)));
      if (!px[0]) continue;
      begin_px = std::min(begin_px, px[0]->x());
      end_px = std::max(end_px, px[0]->x());
      FeatureObservation feature{LandmarkId{1'000'000 + k}, *px[0], std::nullopt};
      if (observations.is_keyframe) feature.px_right = px[1];
      seen.push_back(feature);
    }
    std::erase_if(observations.features, [&](const FeatureObservation& o) {
      return o.px_left.x() > begin_px && o.px_left.x() < end_px;
    });
    observations.features.insert(observations.features.end(), seen.begin(), seen.end());
    most_share_ = std::max(
        most_share_,
        static_cast<double>(seen.size()) / static_cast<double>(observations.features.size()));
  }

  double most_share() const { return most_share_; }

 private:
  static constexpr int kNumPoints = 200;
  static constexpr double kSpeed = 0.8;

  std::array<std::optional<Vector2d>, 2> Pixels(const StereoRig& rig, const Vector3d& p_B) {
    std::array<std::optional<Vector2d>, 2> px;
    for (int c = 0; c < 2; ++c) {
      const CameraModel& camera = rig.cameras[c];
      px[c] = camera.Project(rig.T_BC[c].Inverse() * p_B);
      if (!px[c]) continue;
      *px[c] += 0.3 * rng_.Normal3().head<2>();
      if (!camera.IsInside(*px[c], 0)) px[c].reset();
    }
    return px;
  }

  Rng rng_;
  std::vector<Vector3d> points_;
  double most_share_ = 0;
};

TEST(VioEstimatorTest, AWallThatPassesIsNotTheWorld) {
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    SCOPED_TRACE(seed);
    PassingWall wall(seed);
    const Outcome outcome =
        Estimate([&](std::size_t i, EstimatorInput& input) { wall.Cover(i, input.observations); });
    EXPECT_GT(wall.most_share(), 0.85);
    ExpectRecovers(outcome, 0.02);
    EXPECT_EQ(outcome.num_resets, 0);
    EXPECT_LT(MotionError(outcome, PassingWall::kBegin, outcome.results.size() - 1), 0.04);
  }
}

TEST(VioEstimatorTest, TheSameInputGivesTheSameBits) {
  const Outcome a = Estimate([](std::size_t, EstimatorInput&) {});
  const Outcome b = Estimate([](std::size_t, EstimatorInput&) {});
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

TEST(VioEstimatorTest, EveryFrameAKeyframeOrNoneAfterTheStart) {
  for (const bool keyframe : {false, true}) {
    const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
      if (keyframe || i > 30) input.observations.is_keyframe = keyframe;
    });
    for (const EstimatorResult& result : outcome.results) {
      EXPECT_TRUE(!result.has_state || IsFinite(result));
    }
    EXPECT_TRUE(outcome.results.back().has_state || !keyframe);
  }
}

TEST(VioEstimatorTest, WindowStaysWithinItsLimits) {
  const SimulatedRun& run = testing::SpoiltRun();
  const ImuBuffer imu = testing::ImuOf(run);
  EstimatorOptions options;
  VioEstimator estimator(run.rig, ImuNoise{}, options);
  StageTimes times;
  std::size_t num_finished = 0;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const EstimatorInput input = testing::InputOf(run, imu, i);
    num_finished +=
        estimator.AddFrame(input.observations, input.imu, times).finished_keyframes.size();
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

// The dark needs no keyframe to be noticed, and what has drifted away stays lost.
TEST(VioEstimatorTest, WhoeverIsBlindForLongIsLostAlsoBetweenKeyframes) {
  constexpr std::size_t kDarkFrom = 60;
  for (const bool are_keyframes : {false, true}) {
    const Outcome outcome = Estimate([&](std::size_t i, EstimatorInput& input) {
      if (i < kDarkFrom) return;
      input.observations.features.clear();
      input.observations.is_keyframe = are_keyframes;
    });
    ASSERT_EQ(outcome.num_resets, 1) << are_keyframes;
    std::size_t lost = 0;
    while (!outcome.results[lost].was_reset)
      ++lost;
    EXPECT_GT(lost, kDarkFrom + 40);  // two seconds are bridged
    EXPECT_EQ(outcome.results[lost].status, TrackingStatus::kLost);
    EXPECT_EQ(outcome.results[lost].reason, "position unknown");
    for (std::size_t i = lost; i < outcome.results.size(); ++i)
      EXPECT_FALSE(outcome.results[i].has_state) << i;
  }
}

// Two seconds in the dark and without IMU: the state is lost. What comes after it must not differ
// from what a new estimator makes of the same frames with the same options, none of which is the
// default, but for where the world begins.
TEST(VioEstimatorTest, AfterAResetItIsAsGoodAsNew) {
  EstimatorOptions options;
  options.solver.loss_width = 4;
  options.solver.outlier_sigma = 4.5;
  options.imu.accel_noise_scale = 5;
  options.start.sigma_velocity = 2;
  options.window.max_pose_keyframes = 6;
  options.calibration = CalibrationOptions::Held();  // what was learnt of it outlives the state
  const testing::Spoil spoil = [](std::size_t i, EstimatorInput& input) {
    if (i < testing::kBadBegin || i >= testing::kBadBegin + 40) return;
    input.observations.features.clear();
    input.imu = ImuInterval{};
  };
  const Outcome outcome = Estimate(spoil, options);
  ASSERT_EQ(outcome.num_resets, 1);
  std::size_t first = 0;
  while (!outcome.results[first].was_reset)
    ++first;
  ++first;

  const SimulatedRun& run = testing::SpoiltRun();
  const ImuBuffer imu = testing::ImuOf(run);
  VioEstimator fresh(run.rig, ImuNoise{}, options);
  StageTimes times;
  std::optional<SE3> T_old_new;
  for (std::size_t i = first; i < run.frames.size(); ++i) {
    EstimatorInput input = testing::InputOf(run, imu, i);
    spoil(i, input);
    const EstimatorResult expected = fresh.AddFrame(input.observations, input.imu, times);
    const EstimatorResult& result = outcome.results[i];
    ASSERT_EQ(result.has_state, expected.has_state) << i;
    ASSERT_EQ(result.reason, expected.reason) << i;
    ASSERT_EQ(result.num_constraining, expected.num_constraining) << i;
    if (!result.has_state) continue;
    if (!T_old_new) T_old_new = result.state.T_WB * expected.state.T_WB.Inverse();
    const SE3 T_WB = *T_old_new * expected.state.T_WB;
    EXPECT_LT((result.state.T_WB.p - T_WB.p).norm(), 1e-6) << i;
    EXPECT_LT(result.state.T_WB.q.angularDistance(T_WB.q), 1e-6) << i;
    EXPECT_LT((result.state.bias.b_a - expected.state.bias.b_a).norm(), 1e-6) << i;
  }
  EXPECT_TRUE(T_old_new);
}

}  // namespace
}  // namespace facet
