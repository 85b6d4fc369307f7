// SPDX-License-Identifier: BSD-2-Clause
#include "facet/live/state_predictor.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

constexpr Timestamp kBegin{1'400'000'000'000'000'000};
constexpr Duration kImuStep{5'000'000};
constexpr Duration kFrameStep{50'000'000};

Timestamp At(double seconds) {
  return kBegin + FromSeconds(seconds);
}

/// Swings along x and turns about z.
struct Motion {
  static constexpr double kTurn = 0.8;

  static NavState State(Timestamp t) {
    const double s = ToSeconds(t - kBegin);
    NavState x;
    x.t = t;
    x.T_WB = {ExpSO3({0, 0, kTurn * s}), Vector3d(std::sin(2 * s), 0, 1)};
    x.v_WB = Vector3d(2 * std::cos(2 * s), 0, 0);
    return x;
  }
  static Vector3d Acceleration(Timestamp t) {
    return {-4 * std::sin(2 * ToSeconds(t - kBegin)), 0, 0};
  }
  static ImuSample Imu(Timestamp t) {
    return {t,
            Vector3d(0, 0, kTurn),
            State(t).T_WB.q.conjugate() * (Acceleration(t) - GravityInWorld())};
  }
};

constexpr double kSmoothing_s = 0.1;

class StatePredictorTest : public ::testing::Test {
 protected:
  StatePredictorTest() { Reset({}); }

  /// Samples until 0.3 s, and a frame of 0.2 s that is off.
  void BeginSmoothed(const Vector3d& off_m) {
    PredictionOptions options;
    options.smoothing_s = kSmoothing_s;
    Reset(options);
    AddImuUntil(At(0.3));
    AddFrame(At(0.2), off_m);
  }
  void Reset(const PredictionOptions& options) {
    predictor_.emplace(ImuNoise{}, ImuOptions{}, options);
    next_imu_ = kBegin;
  }
  void AddImuUntil(Timestamp t) {
    for (; next_imu_ <= t; next_imu_ = next_imu_ + kImuStep)
      predictor_->AddImu(Motion::Imu(next_imu_));
  }
  /// `off`: how wrong the frame's position is.
  void AddFrame(Timestamp t, const Vector3d& off = Vector3d::Zero(), int segment = 0) {
    CausalState state;
    state.x = Motion::State(t);
    state.x.T_WB.p += off;
    state.covariance = 1e-6 * Matrix<15, 15>::Identity();
    predictor_->AddFrame(state, true, TrackingStatus::kOk, segment);
  }

  std::optional<StatePredictor> predictor_;
  Timestamp next_imu_;
};

TEST_F(StatePredictorTest, KnowsNothingBeforeTheFirstPose) {
  EXPECT_FALSE(predictor_->PredictAt(kBegin));
  AddImuUntil(At(0.1));
  EXPECT_FALSE(predictor_->PredictAt(At(0.1)));
  predictor_->AddFrame({}, false, TrackingStatus::kInitialising, 0);
  EXPECT_FALSE(predictor_->PredictAt(At(0.1)));
}

TEST_F(StatePredictorTest, FollowsTheMotionBetweenSamplesAndBeyondThem) {
  AddImuUntil(At(0.3));
  AddFrame(At(0.2));
  for (const double t : {0.2, 0.203, 0.25, 0.2975, 0.3, 0.303}) {
    const auto state = predictor_->PredictAt(At(t));
    ASSERT_TRUE(state) << t;
    const NavState truth = Motion::State(At(t));
    EXPECT_EQ(state->t, At(t));
    EXPECT_LT((state->T_WF.p - truth.T_WB.p).norm(), 2e-5) << t;
    EXPECT_LT(state->T_WF.q.angularDistance(truth.T_WB.q), 1e-9) << t;
    EXPECT_LT((state->v_WF - truth.v_WB).norm(), 1e-4) << t;
    EXPECT_LT((state->w_F - Vector3d(0, 0, Motion::kTurn)).norm(), 1e-12) << t;
    EXPECT_LT((state->a_WF - Motion::Acceleration(At(t))).norm(), 0.03) << t;
    EXPECT_NEAR(ToSeconds(state->since_frame), t - 0.2, 1e-9);
    EXPECT_NEAR(ToSeconds(state->since_imu), std::max(0.0, t - 0.3), 1e-9);
    EXPECT_TRUE(state->held_back.isZero(0));
  }
  EXPECT_FALSE(predictor_->PredictAt(At(0.199))) << "before the newest frame";
  EXPECT_FALSE(predictor_->PredictAt(At(1.21))) << "too long after it";
}

TEST_F(StatePredictorTest, AStampBetweenSamplesAndALateStateAreNoDifference) {
  AddImuUntil(At(0.5));
  AddFrame(At(0.2012));
  const auto late = predictor_->PredictAt(At(0.5));
  Reset({});
  AddImuUntil(At(0.21));
  AddFrame(At(0.2012));
  AddImuUntil(At(0.5));
  const auto early = predictor_->PredictAt(At(0.5));
  ASSERT_TRUE(early && late);
  EXPECT_EQ(early->T_WF.p, late->T_WF.p);
  EXPECT_EQ(early->covariance, late->covariance);
  EXPECT_LT((early->T_WF.p - Motion::State(At(0.5)).T_WB.p).norm(), 1e-4);
}

TEST_F(StatePredictorTest, UncertaintyGrowsUntilTheNextFrame) {
  AddImuUntil(At(0.3));
  AddFrame(At(0.2));
  const auto before = predictor_->PredictAt(At(0.3));
  AddFrame(At(0.25));
  const auto after = predictor_->PredictAt(At(0.3));
  ASSERT_TRUE(before && after);
  EXPECT_GT(before->covariance(3, 3), after->covariance(3, 3));
  EXPECT_GT(std::abs(before->covariance(3, 6)), 1e-9) << "a wrong speed leads astray";
  AddFrame(At(0.2));
  EXPECT_EQ(predictor_->PredictAt(At(0.3))->covariance, after->covariance) << "an older one";
}

TEST_F(StatePredictorTest, GoesOnWithoutPosesAndSaysSo) {
  AddImuUntil(At(0.3));
  AddFrame(At(0.2));
  predictor_->AddFrame({}, false, TrackingStatus::kLost, 0);
  AddImuUntil(At(1.2));  // more samples than are kept
  const auto state = predictor_->PredictAt(At(1.2));
  ASSERT_TRUE(state);
  EXPECT_EQ(state->status, TrackingStatus::kLost);
  EXPECT_NEAR(ToSeconds(state->since_frame), 1, 1e-9);
  EXPECT_LT((state->T_WF.p - Motion::State(At(1.2)).T_WB.p).norm(), 1e-3);
  AddImuUntil(At(1.3));
  EXPECT_FALSE(predictor_->PredictAt(At(1.3)));
}

TEST_F(StatePredictorTest, AGlitchIsTakenBack) {
  AddImuUntil(At(0.3));
  AddFrame(At(0.28));
  ImuSample glitch = Motion::Imu(next_imu_);
  glitch.accel.x() += 300;
  predictor_->AddImu(glitch);
  next_imu_ = next_imu_ + kImuStep;
  AddImuUntil(At(0.34));
  const auto state = predictor_->PredictAt(At(0.34));
  ASSERT_TRUE(state);
  EXPECT_LT((state->v_WF - Motion::State(At(0.34)).v_WB).norm(), 2e-3);
}

TEST_F(StatePredictorTest, WithoutSmoothingAFrameCorrectsAtOnce) {
  AddImuUntil(At(0.3));
  AddFrame(At(0.2), Vector3d(0.1, 0, 0));
  AddFrame(At(0.25));
  EXPECT_LT((predictor_->PredictAt(At(0.3))->T_WF.p - Motion::State(At(0.3)).T_WB.p).norm(), 1e-5);
}

TEST_F(StatePredictorTest, SmoothingSpreadsTheCorrectionAndTellsWhatIsLeft) {
  BeginSmoothed(Vector3d(0.1, 0, 0));
  const auto before = predictor_->PredictAt(At(0.3));
  AddFrame(At(0.25));
  const auto after = predictor_->PredictAt(At(0.3));
  ASSERT_TRUE(before && after);
  EXPECT_LT((before->T_WF.p - after->T_WF.p).norm(), 1e-9) << "no jump";
  for (const double since : {0.0, 0.025, 0.05, 0.1, 0.2}) {
    const Timestamp t = At(0.3 + since);
    AddImuUntil(t);
    const auto state = predictor_->PredictAt(t);
    ASSERT_TRUE(state);
    const double left_m = 0.1 * std::max(0.0, 1 - since / kSmoothing_s);
    EXPECT_NEAR((state->T_WF.p - Motion::State(t).T_WB.p).x(), left_m, 1e-4) << since;
    EXPECT_NEAR(state->held_back[3], -left_m, 1e-4) << since;
    const Vector3d estimate = state->T_WF.p + state->held_back.segment<3>(3);
    EXPECT_LT((estimate - Motion::State(t).T_WB.p).norm(), 1e-4);
  }
}

// Each correction has its own time, however many frames come meanwhile.
TEST_F(StatePredictorTest, FramesInBetweenDoNotHoldACorrectionBack) {
  BeginSmoothed(Vector3d(0.1, 0, 0));
  AddFrame(At(0.25));
  for (const double since : {0.02, 0.04, 0.06, 0.08, 0.1, 0.12}) {
    const Timestamp t = At(0.3 + since);
    AddImuUntil(t);
    AddFrame(At(0.25 + since));
    const auto state = predictor_->PredictAt(t);
    ASSERT_TRUE(state);
    const double left_m = 0.1 * std::max(0.0, 1 - since / kSmoothing_s);
    EXPECT_NEAR(state->held_back[3], -left_m, 2e-4) << since;
  }
}

TEST_F(StatePredictorTest, AFrameThatIsNewerThanTheImuDoesNotJumpEither) {
  BeginSmoothed(Vector3d(0.1, 0, 0));
  const auto before = predictor_->PredictAt(At(0.31));
  AddFrame(At(0.31));
  const auto after = predictor_->PredictAt(At(0.31));
  ASSERT_TRUE(before && after);
  EXPECT_LT((before->T_WF.p - after->T_WF.p).norm(), 1e-9);
  EXPECT_NEAR(after->held_back[3], -0.1, 1e-3);
}

TEST_F(StatePredictorTest, ABreakIsNotSmoothed) {
  BeginSmoothed(Vector3d(5, 0, 0));
  AddFrame(At(0.25), Vector3d::Zero(), 1);
  const auto state = predictor_->PredictAt(At(0.3));
  EXPECT_EQ(state->segment, 1);
  EXPECT_LT((state->T_WF.p - Motion::State(At(0.3)).T_WB.p).norm(), 1e-5);
}

PredictedState BodyState() {
  PredictedState state;
  state.T_WF = {ExpSO3({0.3, -0.2, 1.1}), Vector3d(1, -2, 0.5)};
  state.v_WF = Vector3d(0.4, -0.3, 0.2);
  state.w_F = Vector3d(0.5, -0.7, 0.9);
  state.a_WF = Vector3d(1, 2, -0.5);
  Matrix<15, 15> root = Matrix<15, 15>::Identity();
  for (int i = 0; i < 15; ++i) {
    for (int j = 0; j < i; ++j)
      root(i, j) = 0.3 * std::sin(3 * i + 5 * j);
  }
  state.covariance = 1e-4 * root * root.transpose();
  return state;
}

OutputFrame CameraInNed() {
  OutputFrame frame;
  frame.T_BF = {ExpSO3({-1.2, 0.4, 0.3}), Vector3d(0.1, 0.05, -0.2)};
  frame.world = WorldAxes::kNed;
  return frame;
}

TEST(OutputFrameTest, NedIsEnuWithExchangedAxes) {
  const PredictedState body = BodyState();
  OutputFrame frame;
  frame.world = WorldAxes::kNed;
  const PredictedState out = InFrame(body, frame);
  EXPECT_LT((out.T_WF.p - Vector3d(-2, 1, -0.5)).norm(), 1e-12);
  EXPECT_LT((out.v_WF - Vector3d(-0.3, 0.4, -0.2)).norm(), 1e-12);
  const Vector3d x_axis = body.T_WF.q * Vector3d::UnitX();
  EXPECT_LT((out.T_WF.q * Vector3d::UnitX() - Vector3d(x_axis.y(), x_axis.x(), -x_axis.z())).norm(),
            1e-12);
  EXPECT_NEAR(out.covariance(3, 3), body.covariance(4, 4), 1e-15);
  EXPECT_NEAR(out.covariance(3, 5), -body.covariance(4, 5), 1e-15);
}

TEST(OutputFrameTest, VelocityAndAccelerationAreThoseOfTheFrame) {
  // A body that turns steadily about its z axis at rest: a point at radius r moves at w r and
  // accelerates by w^2 r to the centre.
  PredictedState body;
  body.w_F = Vector3d(0, 0, 2);
  OutputFrame frame;
  frame.T_BF.p = Vector3d(0.5, 0, 0);
  const PredictedState out = InFrame(body, frame);
  EXPECT_LT((out.v_WF - Vector3d(0, 1, 0)).norm(), 1e-12);
  EXPECT_LT((out.a_WF - Vector3d(-2, 0, 0)).norm(), 1e-12);
  EXPECT_LT((out.w_F - body.w_F).norm(), 1e-12);
}

TEST(OutputFrameTest, CovarianceIsThatOfNumericDerivatives) {
  const PredictedState body = BodyState();
  const OutputFrame frame = CameraInNed();
  const PredictedState out = InFrame(body, frame);
  const Matrix<15, 15> J =
      facet::testing::NumericJacobian<15, 15>([&](const Vector<15>& d) -> Vector<15> {
        PredictedState moved = body;
        moved.T_WF.q = body.T_WF.q * ExpSO3(d.head<3>());
        moved.T_WF.p += d.segment<3>(3);
        moved.v_WF += d.segment<3>(6);
        moved.w_F -= d.segment<3>(9);
        const PredictedState end = InFrame(moved, frame);
        Vector<15> difference;
        difference << LogSO3(out.T_WF.q.conjugate() * end.T_WF.q), end.T_WF.p - out.T_WF.p,
            end.v_WF - out.v_WF, d.tail<6>();
        return difference;
      });
  const Matrix<15, 15> expected = J * body.covariance * J.transpose();
  EXPECT_LT((out.covariance - expected).cwiseAbs().maxCoeff(),
            1e-7 * expected.cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace facet
