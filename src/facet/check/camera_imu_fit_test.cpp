// SPDX-License-Identifier: BSD-2-Clause
// Turns of a made-up motion: what is wrong is found to its uncertainty, whatever part of it.
#include "facet/check/camera_imu_fit.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

// Angular rate of the body [rad/s].
Vector3d RateAt(double t_s) {
  return {0.5 * std::sin(2.1 * t_s) + 0.2 * std::sin(7.3 * t_s),
          0.6 * std::cos(1.7 * t_s) + 0.2 * std::sin(5.9 * t_s + 1),
          0.4 * std::sin(2.9 * t_s + 2)};
}

struct MadeUp {
  std::vector<ImageTurn> turns;
  GyroTrack gyro;
};

/// 20 s; the gyroscope reads as `truth` says, beside 2 mrad of noise on the turns.
MadeUp Make(const CameraImuModel& truth, double noise = 0.002) {
  constexpr double kStep_s = 0.001;
  MadeUp made;
  Rng rng(5);
  GyroTrack exact;
  for (double t_s = -1; t_s < 22; t_s += kStep_s) {
    exact.Add(Timestamp{} + FromSeconds(t_s), RateAt(t_s));
    // What happens at t is stamped tau later.
    made.gyro.Add(Timestamp{} + FromSeconds(t_s + truth.tau_s), RateAt(t_s) + truth.bias);
  }
  for (int i = 0; i < 100; ++i) {
    const double t_s = 0.2 * i;
    ImageTurn turn;
    turn.begin = Timestamp{} + FromSeconds(t_s);
    turn.end = Timestamp{} + FromSeconds(t_s + 0.2);
    Vector3d theta_B;
    EXPECT_TRUE(exact.Turn(turn.begin, turn.end, theta_B));
    turn.rotation.theta =
        std::exp(truth.log_scale) * (truth.R_CB * theta_B) + noise * rng.Normal3();
    turn.rotation.covariance = noise * noise * Matrix3d::Identity();
    made.turns.push_back(turn);
  }
  return made;
}

TEST(GyroTrackTest, ATurnIsTheProductOfItsParts) {
  const MadeUp made = Make({});
  Vector3d whole, first, second;
  const Timestamp begin = Timestamp{} + FromSeconds(3.0003);
  const Timestamp middle = Timestamp{} + FromSeconds(3.1777);
  const Timestamp end = Timestamp{} + FromSeconds(3.5001);
  ASSERT_TRUE(made.gyro.Turn(begin, end, whole));
  ASSERT_TRUE(made.gyro.Turn(begin, middle, first));
  ASSERT_TRUE(made.gyro.Turn(middle, end, second));
  EXPECT_LT((LogSO3(ExpSO3(first) * ExpSO3(second)) - whole).norm(), 1e-6);
  EXPECT_FALSE(made.gyro.Turn(begin, Timestamp{} + FromSeconds(100), whole));
}

TEST(CameraImuFitTest, ErrorsOfAllKindsAreFoundTogether) {
  CameraImuModel truth;
  const Quaterniond mount = ExpSO3(Vector3d(1.2, -0.4, 0.8));
  const Vector3d turn(0.05, -0.02, 0.03);
  truth.R_CB = mount * ExpSO3(turn);
  truth.log_scale = 0.05;
  truth.bias = {0.1, -0.2, 0.05};
  truth.tau_s = 0.02;
  const MadeUp made = Make(truth);
  CameraImuModel start;
  start.R_CB = mount;
  const CameraImuFit fit = FitCameraImu(made.turns, made.gyro, start);
  EXPECT_EQ(fit.num_turns, 100);
  // Within four times what the fit says it may be off by, which is little.
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(fit.turned[k], turn[k], 4 * fit.Sigma(k));
    EXPECT_NEAR(fit.model.bias[k], truth.bias[k], 4 * fit.Sigma(4 + k));
    EXPECT_LT(fit.Sigma(k), 0.006);
    EXPECT_LT(fit.Sigma(4 + k), 0.003);
  }
  EXPECT_NEAR(fit.model.log_scale, truth.log_scale, 4 * fit.Sigma(3));
  EXPECT_NEAR(fit.model.tau_s, truth.tau_s, 4 * fit.Sigma(7));
  EXPECT_LT(fit.Sigma(3), 0.006);
  EXPECT_LT(fit.Sigma(7), 0.002);
  EXPECT_GT(fit.TurnedSigmas(), 10);
}

TEST(CameraImuFitTest, AThirdOfWrongTurnsDoesNotMatter) {
  CameraImuModel truth;
  truth.tau_s = -0.015;
  MadeUp made = Make(truth);
  Rng rng(9);
  for (std::size_t i = 0; i < made.turns.size(); i += 3)
    made.turns[i].rotation.theta = 0.3 * rng.Normal3();
  const CameraImuFit fit = FitCameraImu(made.turns, made.gyro, {});
  EXPECT_NEAR(fit.model.tau_s, truth.tau_s, 0.003);
  EXPECT_LT(fit.turned.norm(), 0.01);
}

TEST(CameraImuFitTest, ALargeOffsetIsFoundWhateverTheMount) {
  CameraImuModel truth;
  truth.R_CB = ExpSO3(Vector3d(0, 2.5, 1));
  truth.tau_s = 0.31;
  const MadeUp made = Make(truth);
  EXPECT_NEAR(RoughTimeOffset(made.turns, made.gyro), 0.31, 0.011);
  EXPECT_NEAR(FitTimeOffset(made.turns, made.gyro, truth).first, 0.31, 0.001);
  const MadeUp without = Make({});
  EXPECT_EQ(RoughTimeOffset(without.turns, without.gyro), 0);
}

}  // namespace
}  // namespace facet
