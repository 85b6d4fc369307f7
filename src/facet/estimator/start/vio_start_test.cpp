// SPDX-License-Identifier: BSD-2-Clause
// The start alone, frame by frame, on perfect IMU samples and points seen with little noise.
#include "facet/estimator/start/vio_start.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "facet/estimator/window/frame_observations.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

using testing::TestMotion;

constexpr double kStep_s = 0.05;

TestMotion SlowMotion(std::uint64_t seed) {
  Rng rng(seed);
  TestMotion motion = TestMotion::Random(rng);
  motion.v0 *= 0.5;
  return motion;
}

TestMotion AtRest() {
  TestMotion rest;
  rest.q0 = ExpSO3({0.5, -0.3, 0.2});
  return rest;
}

// Along the left camera's x axis: no two frames are at the same place.
TestMotion Straight() {
  TestMotion motion = AtRest();
  motion.v0 = motion.q0 * (testing::MakeTestRig().T_BC[0].q * Vector3d::UnitX());
  return motion;
}

// What the estimator does around VioStart: one frame after the other comes into the window.
class Recording {
 public:
  Recording(const TestMotion& motion, const EstimatorOptions& options = {})
      : start(rig, options),
        optimizer(rig, options),
        window(rig.T_BC[0]),
        options_(options),
        motion_(motion),
        imu_(ImuNoise{}, options.imu, Duration{}) {
    const SE3 T_WC = motion.At(0).T_WB * rig.T_BC[0];
    for (int k = 0; k < 80; ++k) {
      const double depth = rng_.Uniform(2, 6);
      points_W_.push_back(T_WC *
                          (depth * Vector3d(rng_.Uniform(-0.6, 0.6), rng_.Uniform(-0.5, 0.5), 1)));
    }
  }

  struct Frame {
    bool is_dark = false;
    bool has_imu = true;
    Vector3d gyro_error = Vector3d::Zero();  // of the samples up to this frame [rad/s]
    bool is_repeated = false;                // the image is that of the first frame
  };
  // The next frame; tries to start while there is no state.
  StartAttempt Add(const Frame& frame) {
    const double t = kStep_s * num_frames_++;
    WindowFrame next;
    next.id = FrameId{num_frames_};
    next.is_keyframe = next.is_reported = true;
    next.x.t = Timestamp{} + FromSeconds(t);
    ImuInterval imu = frame.has_imu ? Samples(t - kStep_s, t) : ImuInterval{};
    for (ImuSample& sample : imu.samples)
      sample.gyro += frame.gyro_error;
    if (window.frames.empty()) {
      imu_.Begin(next.x.t);
      VioStart::AppendFirstFrame(next, imu, options_.start, window);
    } else {
      PredictedFrame predicted = imu_.Next(window.frames.back().x, std::nullopt, next.x.t, imu);
      next.x = next.lin = predicted.x;
      next.imu_link = std::move(predicted.link);
      window.frames.push_back(next);
    }
    if (!frame.is_dark) Observe(motion_.At(frame.is_repeated ? 0 : t));
    return start.has_state() ? StartAttempt{} : start.Try(start_pose, imu_, optimizer, window);
  }
  // Until it starts, but no more than so many; the last attempt.
  StartAttempt AddGoodFrames(int max_frames) {
    StartAttempt attempt;
    for (int i = 0; i < max_frames && !attempt.has_started; ++i)
      attempt = Add({});
    return attempt;
  }
  bool EndIfDue(const Matrix<15, 15>& covariance) {
    return start.EndIfDue(covariance, imu_, optimizer, window, finished);
  }
  NavState Truth() const { return motion_.At(kStep_s * (num_frames_ - 1)); }

  StereoRig rig = testing::MakeTestRig();
  VioStart start;
  WindowOptimizer optimizer;
  SlidingWindow window;
  std::optional<SE3> start_pose;
  std::vector<KeyframePose> finished;

 private:
  ImuInterval Samples(double t0, double t1) const {
    ImuInterval interval;
    for (int i = 0; i <= 10; ++i)
      interval.samples.push_back(motion_.ImuAt(t0 + i * (t1 - t0) / 10, ImuBias{}));
    return interval;
  }

  void Observe(const NavState& truth) {
    std::vector<PreparedObservation> prepared;
    for (std::size_t k = 0; k < points_W_.size(); ++k) {
      PreparedObservation p{LandmarkId{static_cast<std::int64_t>(k)}, {}};
      p.observation.has_right = true;
      for (int c = 0; c < 2; ++c) {
        testing::SetMeasurement(
            (truth.T_WB * rig.T_BC[c]).Inverse() * points_W_[k], c, 0.5, p.observation);
        const double x = rng_.Normal(), y = rng_.Normal();
        testing::ShiftMeasurement(0.2 / 450 * Vector2d(x, y), c, p.observation);
      }
      prepared.push_back(p);
    }
    AppendObservations(prepared, window);
  }

  EstimatorOptions options_;
  TestMotion motion_;
  ImuIntervals imu_;
  Rng rng_{3};
  std::vector<Vector3d> points_W_;
  int num_frames_ = 0;
};

double TiltError(const NavState& x, const NavState& truth) {
  const Vector3d up = x.T_WB.q.conjugate() * Vector3d::UnitZ();
  return std::acos(std::min(1.0, up.dot(truth.T_WB.q.conjugate() * Vector3d::UnitZ())));
}

Matrix<15, 15> CovarianceOfTilt(double sigma_rad) {
  return sigma_rad * sigma_rad * Matrix<15, 15>::Identity();
}

// What would be a state with a wrong heading and a wrong bias.
TEST(VioStartTest, WaitsUntilAGlitchOfTheGyroscopeHasLeftTheWindow) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Recording recording(SlowMotion(seed));
    recording.Add({});
    recording.Add({});
    StartAttempt attempt;
    for (int i = 0; i < 3; ++i)
      attempt = recording.Add({.gyro_error = Vector3d(2, -1, 3)});
    std::string reason;
    int num_frames = 5;
    while (!attempt.has_started && num_frames++ < 60) {
      attempt = recording.Add({});
      if (!attempt.has_started) reason = attempt.reason;
    }
    ASSERT_TRUE(attempt.has_started) << reason;
    EXPECT_EQ(reason, "IMU and images contradict each other");
    const NavState& newest = recording.window.frames.back().x;
    const NavState truth = recording.Truth();
    const Vector3d v_B = newest.T_WB.q.conjugate() * newest.v_WB;
    EXPECT_LT((v_B - truth.T_WB.q.conjugate() * truth.v_WB).norm(), 0.02) << seed;
    EXPECT_LT(newest.bias.b_g.norm(), 0.01) << seed;
  }
}

TEST(VioStartTest, WaitsUntilImagesThatRepeatTheFirstHaveLeftTheWindow) {
  Recording recording(SlowMotion(2));
  StartAttempt attempt;
  for (int i = 0; i < 12; ++i) {
    attempt = recording.Add({.is_repeated = true});
    EXPECT_FALSE(attempt.has_started);
  }
  for (int i = 0; i < 30 && !attempt.has_started; ++i)
    attempt = recording.Add({});
  ASSERT_TRUE(attempt.has_started) << attempt.reason;
  EXPECT_LT(recording.window.frames.back().x.bias.b_g.norm(), 0.01);
}

// Whoever judges sensors and calibration needs a state.
TEST(VioStartTest, DoesNotWaitForEverForAnImuThatIsWrong) {
  Recording recording(SlowMotion(3));
  StartAttempt attempt;
  int num_frames = 0;
  while (!attempt.has_started && num_frames < 100)
    attempt = recording.Add({.gyro_error = (++num_frames % 2 == 0 ? 1 : -1) * Vector3d(2, 1, -2)});
  EXPECT_TRUE(attempt.has_started) << attempt.reason;
  EXPECT_GT(num_frames, 40);
}

TEST(VioStartTest, TheFirstFrameIsUprightAndHeld) {
  StartOptions options;
  options.sigma_yaw = 0.123;
  options.sigma_velocity = 0.456;
  const Quaterniond q_WB = ExpSO3({0.4, -0.7, 0});
  ImuInterval imu;
  imu.samples.push_back({Timestamp{}, Vector3d::Zero(), -(q_WB.conjugate() * GravityInWorld())});
  WindowFrame frame;
  frame.id = FrameId{4};
  SlidingWindow window;
  VioStart::AppendFirstFrame(frame, imu, options, window);
  ASSERT_EQ(window.frames.size(), 1u);
  EXPECT_LT(window.frames[0].x.T_WB.q.angularDistance(q_WB), 1e-9);
  ASSERT_TRUE(window.start_prior);
  EXPECT_EQ(window.start_prior->frame, FrameId{4});
  EXPECT_EQ(window.start_prior->sigma_yaw, 0.123);
  EXPECT_EQ(window.start_prior->sigma_velocity, 0.456);
}

TEST(VioStartTest, EnoughFramesGiveAStateAtTheOrigin) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Recording run(SlowMotion(seed));
    for (int i = 0; i < 6; ++i) {
      const StartAttempt attempt = run.Add({});
      EXPECT_FALSE(attempt.has_started);
      EXPECT_EQ(attempt.reason, "collecting frames");
    }
    const StartAttempt attempt = run.AddGoodFrames(5);
    ASSERT_TRUE(attempt.has_started) << attempt.reason;
    EXPECT_TRUE(run.start.has_state());
    EXPECT_TRUE(attempt.solve.ok);
    EXPECT_EQ(attempt.num_constraining, 80);
    const NavState& x = run.window.frames.back().x;
    EXPECT_LT(TiltError(x, run.Truth()), 2 * kDegree);
    EXPECT_LT(x.T_WB.p.norm(), 1e-3);
    const Vector3d v_B = x.T_WB.q.conjugate() * x.v_WB;
    EXPECT_LT((v_B - run.Truth().T_WB.q.conjugate() * run.Truth().v_WB).norm(), 0.1);
    EXPECT_GT(attempt.covariance.diagonal().minCoeff(), 0);
  }
}

TEST(VioStartTest, NothingBeginsWithoutImuOrInTheDark) {
  Recording run(SlowMotion(1));
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(run.Add({.has_imu = false}).reason, i == 0 ? "collecting frames" : "no IMU");
  EXPECT_EQ(run.window.frames.size(), 1u) << "the frames before are of no use";
  for (int i = 0; i < 10; ++i)
    EXPECT_FALSE(run.Add({.is_dark = true}).has_started);
  EXPECT_LE(run.window.frames.size(), 11u);
  EXPECT_TRUE(run.AddGoodFrames(12).has_started);
}

// A picture that freezes at once, or a lens that is covered: what the IMU alone says of the frames
// since then is no start.
TEST(VioStartTest, FramesWithoutAnImageDoNotCount) {
  Recording run(SlowMotion(4));
  EXPECT_FALSE(run.AddGoodFrames(3).has_started);
  for (int i = 0; i < 40; ++i) {
    const StartAttempt attempt = run.Add({.is_dark = true});
    EXPECT_FALSE(attempt.has_started);
    EXPECT_EQ(attempt.reason, "collecting frames");
  }
  EXPECT_LE(run.window.frames.size(), 30u);
  EXPECT_TRUE(run.AddGoodFrames(12).has_started);
  EXPECT_LT(TiltError(run.window.frames.back().x, run.Truth()), 0.02);
}

TEST(VioStartTest, SaysWhatIsMissing) {
  EstimatorOptions options;
  options.start.min_landmarks = 81;
  Recording few_landmarks(SlowMotion(1), options);
  EXPECT_EQ(few_landmarks.AddGoodFrames(8).reason, "too few stereo landmarks");
  Recording little_imu(SlowMotion(1));
  for (const bool has_imu : {true, true, false, true, false, true, true})
    little_imu.Add({.has_imu = has_imu});
  EXPECT_EQ(little_imu.Add({}).reason, "too little IMU");
  options = {};
  options.start.max_tilt_deg = 1e-6;
  Recording uncertain(SlowMotion(1), options);
  EXPECT_EQ(uncertain.AddGoodFrames(8).reason, "tilt not known well enough");
  EXPECT_TRUE(uncertain.AddGoodFrames(3).has_started) << "but it does not wait for ever";
}

// After the estimator was lost.
TEST(VioStartTest, TakesOverPlaceAndHeading) {
  Recording run(SlowMotion(2));
  run.start_pose = SE3(ExpSO3({0, 0, 1.2}), Vector3d(3, -2, 1));
  ASSERT_TRUE(run.AddGoodFrames(10).has_started);
  const NavState& x = run.window.frames.back().x;
  EXPECT_LT((x.T_WB.p - run.start_pose->p).norm(), 1e-3);
  const Quaterniond difference = run.start_pose->q * x.T_WB.q.conjugate();
  EXPECT_NEAR(2 * std::atan2(difference.z(), difference.w()), 0, 0.01);
}

TEST(VioStartTest, ItIsOverWhenTheTiltIsCertainButNotBeforeItsTime) {
  Recording run(SlowMotion(3));
  ASSERT_TRUE(run.AddGoodFrames(10).has_started);
  const EstimatorOptions options;
  const Matrix<15, 15> certain = CovarianceOfTilt(0.5 * options.window.start_tilt_deg * kDegree);
  EXPECT_FALSE(run.EndIfDue(certain));
  const int enough = static_cast<int>(options.window.start_s / kStep_s);
  while (static_cast<int>(run.window.frames.size()) <= enough)
    run.Add({});
  EXPECT_TRUE(run.EndIfDue(certain));
  EXPECT_TRUE(run.EndIfDue(CovarianceOfTilt(1))) << "once over, always over";
  EXPECT_TRUE(run.finished.empty());
}

// At rest duplicates go, one by one, and leave their IMU behind; in motion there are none.
TEST(VioStartTest, AtRestItGoesOnWithoutAGrowingWindow) {
  EstimatorOptions options;
  options.window.start_s = 0.5;
  Recording rest(AtRest(), options), moving(Straight(), options);
  const Matrix<15, 15> uncertain = CovarianceOfTilt(1 * kDegree);
  for (int i = 0; i < 30; ++i) {
    rest.Add({});
    moving.Add({});
    if (i < 12) continue;
    const std::size_t before = rest.window.frames.size();
    EXPECT_FALSE(rest.EndIfDue(uncertain));
    EXPECT_EQ(rest.window.frames.size(), before - 1);
  }
  EXPECT_EQ(rest.finished.size(), 18u);
  double time_s = 0;
  for (const WindowFrame& frame : rest.window.frames)
    time_s += frame.imu_link ? frame.imu_link->measured.dt() : 0;
  EXPECT_NEAR(time_s, 29 * kStep_s, 1e-6);
  EXPECT_TRUE(moving.EndIfDue(uncertain));
}

}  // namespace
}  // namespace facet
