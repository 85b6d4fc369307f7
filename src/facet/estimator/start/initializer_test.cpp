// SPDX-License-Identifier: BSD-2-Clause
// The start from seven stereo frames, at rest and in motion, with any tilt.
#include "facet/estimator/start/initializer.h"

#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "facet/estimator/window/landmark_depth.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

using testing::TestMotion;
using testing::TestWindow;

testing::TestWindowOptions Options(Rng& rng) {
  testing::TestWindowOptions options;
  options.num_frames = 7;
  options.frame_interval_s = 0.05;
  options.num_landmarks = 60;
  options.max_depth = 6;
  options.right_share = 1;
  options.pixel_sigma = 0.3;
  options.bias = {0.1 * rng.UnitVector(), 0.05 * rng.UnitVector()};
  return options;
}

// As the estimator hands it over: nothing known but stereo depths and IMU integrated without
// biases.
void Forget(TestWindow& test) {
  for (WindowFrame& frame : test.window.frames) {
    const Timestamp t = frame.x.t;
    frame.x = frame.lin = NavState();
    frame.x.t = t;
    if (frame.imu_link) frame.imu_link->measured.Reintegrate({}, Vector3d::Zero());
  }
  FrameGeometry geometry(test.rig);
  geometry.Update(test.window.frames);
  for (WindowLandmark& landmark : test.window.landmarks()) {
    // The first stereo pair alone: the poses mean nothing yet.
    const std::vector<WindowObservation> all = landmark.observations;
    landmark.observations.resize(1);
    landmark.has_depth = false;
    EXPECT_TRUE(InitializeDepth(geometry, landmark));
    landmark.observations = all;
  }
}

struct StartError {
  double tilt_deg = 0, velocity = 0, gyro_bias = 0;
};

// Largest errors over all frames; velocity in the body frame, where no heading is needed.
StartError ErrorOf(const TestWindow& test) {
  StartError error;
  for (std::size_t i = 0; i < test.truth.size(); ++i) {
    const NavState& x = test.window.frames[i].x;
    const NavState& truth = test.truth[i];
    const Vector3d up = x.T_WB.q.conjugate() * Vector3d::UnitZ();
    const Vector3d true_up = truth.T_WB.q.conjugate() * Vector3d::UnitZ();
    const Vector3d v = x.T_WB.q.conjugate() * x.v_WB - truth.T_WB.q.conjugate() * truth.v_WB;
    error.tilt_deg = std::max(error.tilt_deg, std::acos(std::min(1.0, up.dot(true_up))) / kDegree);
    error.velocity = std::max(error.velocity, v.norm());
    error.gyro_bias = std::max(error.gyro_bias, (x.bias.b_g - truth.bias.b_g).norm());
  }
  return error;
}

void ExpectStarts(TestWindow test, StartError& worst) {
  Forget(test);
  const auto result = InitializeFromStereo(test.rig, EstimatorOptions{}, test.window);
  ASSERT_TRUE(result.ok) << result.reason;
  const StartError error = ErrorOf(test);
  EXPECT_LT(error.tilt_deg, 2.0);
  EXPECT_LT(error.velocity, 0.1);
  EXPECT_LT(error.gyro_bias, 0.01);
  worst.tilt_deg = std::max(worst.tilt_deg, error.tilt_deg);
  worst.velocity = std::max(worst.velocity, error.velocity);
  worst.gyro_bias = std::max(worst.gyro_bias, error.gyro_bias);
  for (const WindowFrame& frame : test.window.frames) {
    EXPECT_TRUE(frame.has_motion);
    EXPECT_FALSE(frame.pose_frozen);
    EXPECT_EQ(testing::Difference(frame.x, frame.lin).norm(), 0);
  }
  EXPECT_EQ(test.window.prior.dim(), 0);
}

void Print(const char* name, const StartError& e) {
  std::cout << name << ", worst: tilt " << e.tilt_deg << " deg, velocity " << e.velocity
            << " m/s, gyro bias " << e.gyro_bias << " rad/s\n";
}

TEST(InitializerTest, StartsInMotion) {
  StartError worst;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Rng rng(seed);
    ExpectStarts(testing::MakeTestWindow(Options(rng), rng), worst);
  }
  Print("in motion", worst);
}

TEST(InitializerTest, StartsAtRest) {
  StartError worst;
  for (std::uint64_t seed = 21; seed <= 40; ++seed) {
    Rng rng(seed);
    TestMotion rest;
    // From upright to upside down.
    rest.q0 = ExpSO3(static_cast<double>(seed - 21) / 19 * M_PI * Vector3d(0.6, 0.8, 0));
    ExpectStarts(testing::MakeTestWindow(Options(rng), rest, rng), worst);
  }
  Print("at rest", worst);
}

TEST(InitializerTest, KeepsPositionAndHeadingOfTheFirstFrameWhenItIsLevel) {
  Rng rng(50);
  TestMotion level;
  level.v0 = Vector3d(0.4, -0.2, 0.1);
  TestWindow test = testing::MakeTestWindow(Options(rng), level, rng);
  Forget(test);
  ASSERT_TRUE(InitializeFromStereo(test.rig, EstimatorOptions{}, test.window).ok);
  EXPECT_LT(test.window.frames[0].x.T_WB.p.norm(), 1e-6);
  EXPECT_LT(std::abs(LogSO3(test.window.frames[0].x.T_WB.q).z()), 1e-3);
}

TEST(InitializerTest, RefusesTooFewFrames) {
  Rng rng(51);
  testing::TestWindowOptions options = Options(rng);
  options.num_frames = 2;
  TestWindow test = testing::MakeTestWindow(options, rng);
  Forget(test);
  const auto result = InitializeFromStereo(test.rig, EstimatorOptions{}, test.window);
  EXPECT_FALSE(result.ok);
  EXPECT_NE(result.reason.find("three frames"), std::string::npos) << result.reason;
}

TEST(InitializerTest, RefusesWithoutLandmarks) {
  Rng rng(52);
  TestWindow test = testing::MakeTestWindow(Options(rng), rng);
  Forget(test);
  test.window.RemoveLandmarks(std::vector<char>(test.window.landmarks().size(), 1));
  const auto result = InitializeFromStereo(test.rig, EstimatorOptions{}, test.window);
  EXPECT_FALSE(result.ok);
  EXPECT_FALSE(result.reason.empty());
}

// Images of another motion than the IMU's: gravity comes out wrong.
TEST(InitializerTest, RefusesWhenGravityIsWrong) {
  Rng rng(53);
  TestWindow test = testing::MakeTestWindow(Options(rng), rng);
  for (WindowFrame& frame : test.window.frames) {
    if (!frame.imu_link) continue;
    std::vector<ImuSample> samples = frame.imu_link->measured.samples();
    for (ImuSample& sample : samples)
      sample.accel *= 0.5;
    frame.imu_link->measured = ImuPreintegration({}, {});
    frame.imu_link->measured.Integrate(samples);
  }
  Forget(test);
  const auto result = InitializeFromStereo(test.rig, EstimatorOptions{}, test.window);
  EXPECT_FALSE(result.ok);
  EXPECT_NE(result.reason.find("gravity"), std::string::npos) << result.reason;
}

TEST(InitializerTest, RefusesWithoutImu) {
  Rng rng(54);
  TestWindow test = testing::MakeTestWindow(Options(rng), rng);
  for (WindowFrame& frame : test.window.frames) {
    if (frame.imu_link) frame.imu_link->measured = ImuPreintegration();
  }
  Forget(test);
  const auto result = InitializeFromStereo(test.rig, EstimatorOptions{}, test.window);
  EXPECT_FALSE(result.ok);
  EXPECT_FALSE(result.reason.empty());
}

}  // namespace
}  // namespace facet
