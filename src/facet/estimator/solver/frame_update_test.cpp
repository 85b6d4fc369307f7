// SPDX-License-Identifier: BSD-2-Clause
// The light update of a frame between keyframes against the joint solution of window and frame.
#include "facet/estimator/solver/frame_update.h"

#include <cmath>
#include <iostream>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "facet/estimator/solver/window_solver.h"
#include "facet/geometry/so3.h"
#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

using testing::TestWindow;

// A solved window, and the frame that follows it with everything that was measured.
struct Case {
  StereoRig rig;
  SlidingWindow window;             // without the frame, solved
  SlidingWindow joint;              // with it, solved
  Matrix<15, 15> covariance;        // of the newest frame of the window
  Matrix<15, 15> joint_covariance;  // of the frame
  NavState predicted;               // of the frame
  ImuLink imu;                      // from the newest frame of the window
  std::vector<PreparedObservation> observations;
  NavState truth;
};

SolverOptions Options() {
  SolverOptions options;
  options.frame_iterations = 5;
  options.loss_width =
      1e6;  // the light update weights with the landmark's uncertainty: compare without
  options.outlier_sigma = 1e6;
  options.min_cost_decrease = 1e-9;
  return options;
}

FactorNoise Noise() {
  EstimatorOptions options;
  options.solver = Options();
  return FactorNoise(options);
}

// Cuts the last frame off the window.
void TakeLastFrame(TestWindow& test, Case& out) {
  const int last = test.window.newest_frame();
  out.imu = test.window.frames.back().imu_link.value();
  for (WindowLandmark& landmark : test.window.landmarks()) {
    for (const WindowObservation& o : landmark.observations) {
      if (o.frame == last) out.observations.push_back({landmark.id, o});
    }
  }
  test.window.RemoveFrame(last);
}

Case MakeCase(std::uint64_t seed) {
  Rng rng(seed);
  testing::TestWindowOptions options;
  options.num_frames = 10;
  options.num_landmarks = 90;
  options.frame_interval_s = 0.15;
  TestWindow test = testing::MakeTestWindow(options, rng);
  // Origin and heading are off by what the prior says.
  StartPrior prior(FrameId{0}, test.truth[0].T_WB, StartOptions{});
  prior.T_WB.p += prior.sigma_position * rng.Normal3();
  prior.T_WB.q = ExpSO3({0, 0, prior.sigma_yaw * rng.Normal()}) * prior.T_WB.q;
  test.window.start_prior = prior;
  Case out;
  out.rig = test.rig;
  out.truth = test.truth.back();
  out.joint = test.window;
  TakeLastFrame(test, out);
  out.window = std::move(test.window);
  // A landmark needs a second view in either window to be the same in both.
  for (WindowLandmark& landmark : out.window.landmarks())
    landmark.has_depth = landmark.observations.size() >= 2;
  for (WindowLandmark& landmark : out.joint.landmarks()) {
    const WindowLandmark* other = out.window.Find(landmark.id);
    landmark.has_depth = other != nullptr && other->has_depth;
  }
  WindowSolver solver(out.rig, Options());
  solver.Solve(out.joint, Noise(), 30);
  out.joint_covariance = solver.NewestFrameCovariance();
  solver.Solve(out.window, Noise(), 30);
  out.covariance = solver.NewestFrameCovariance();
  const NavState& reference = out.window.frames.back().x;
  out.imu.measured.Reintegrate(reference.bias, Vector3d::Zero());
  out.imu.sqrt_info = ImuSqrtInfo(out.imu.measured, testing::DefaultBiasWalk());
  out.predicted = out.imu.measured.Predict(reference);
  return out;
}

TEST(FrameUpdateTest, AgreesWithTheJointSolution) {
  double sum_before = 0, sum_after = 0;
  constexpr int kRuns = 20;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const Case c = MakeCase(seed);
    NavState x = c.predicted;
    const Vector<15> sigma = c.joint_covariance.diagonal().cwiseSqrt();
    const auto deviation = [&](const NavState& from) {
      const Vector<15> d = testing::Difference(c.joint.frames.back().x, from);
      return d.cwiseQuotient(sigma).head<9>().norm() / 3;
    };
    sum_before += deviation(x);
    FrameUpdater updater(c.rig, Options(), testing::DefaultBiasWalk());
    updater.SetReference(c.window, c.covariance, Noise());
    const FrameUpdateResult result = updater.Update(c.observations, c.imu, Noise(), x);
    ASSERT_TRUE(result.ok);
    EXPECT_GT(result.num_used, 20);
    sum_after += deviation(x);
    EXPECT_LT(deviation(x), 1.0);
  }
  std::cout << "rms deviation from the joint solution in its sigmas (theta p v): predicted "
            << sum_before / kRuns << ", updated " << sum_after / kRuns << '\n';
  EXPECT_LT(sum_after / kRuns, 0.25);
  EXPECT_LT(sum_after, 0.7 * sum_before);
}

double Nees(const NavState& truth,
            const NavState& x,
            const Matrix<15, 15>& covariance,
            int first,
            int size) {
  const VectorXd error = testing::Difference(truth, x).segment(first, size);
  return error.dot(MatrixXd(covariance.block(first, first, size, size)).ldlt().solve(error));
}

// Somewhat cautious, as the joint solution is: the biases of the simulation do not walk.
TEST(FrameUpdateTest, CovarianceIsConsistent) {
  double pose = 0, velocity = 0, joint_pose = 0, joint_velocity = 0;
  constexpr int kRuns = 100;
  for (std::uint64_t seed = 101; seed <= 100 + kRuns; ++seed) {
    const Case c = MakeCase(seed);
    NavState x = c.predicted;
    FrameUpdater updater(c.rig, Options(), testing::DefaultBiasWalk());
    updater.SetReference(c.window, c.covariance, Noise());
    const FrameUpdateResult result = updater.Update(c.observations, c.imu, Noise(), x);
    ASSERT_TRUE(result.ok);
    EXPECT_EQ(Eigen::LLT<MatrixXd>(result.covariance).info(), Eigen::Success);
    const NavState& joint = c.joint.frames.back().x;
    pose += Nees(c.truth, x, result.covariance, 0, 6) / kRuns;
    velocity += Nees(c.truth, x, result.covariance, 6, 3) / kRuns;
    joint_pose += Nees(c.truth, joint, c.joint_covariance, 0, 6) / kRuns;
    joint_velocity += Nees(c.truth, joint, c.joint_covariance, 6, 3) / kRuns;
  }
  std::cout << "mean NEES: pose " << pose << " (joint solution " << joint_pose
            << ") of 6, velocity " << velocity << " (" << joint_velocity << ") of 3\n";
  // 99 % intervals of the mean of 100 chi-square variables.
  const double pose_interval = 2.576 * std::sqrt(12.0 / kRuns);
  const double velocity_interval = 2.576 * std::sqrt(6.0 / kRuns);
  EXPECT_NEAR(joint_pose, 6, pose_interval);
  EXPECT_NEAR(joint_velocity, 3, velocity_interval);
  EXPECT_NEAR(velocity, 3, velocity_interval);
  EXPECT_LT(pose, 6 + pose_interval);
  EXPECT_GT(pose, 0.8 * joint_pose);
}

TEST(FrameUpdateTest, WithoutObservationsTheFrameFollowsTheImu) {
  const Case c = MakeCase(300);
  NavState x = c.predicted;
  FrameUpdater updater(c.rig, Options(), testing::DefaultBiasWalk());
  updater.SetReference(c.window, c.covariance, Noise());
  const FrameUpdateResult result = updater.Update({}, c.imu, Noise(), x);
  ASSERT_TRUE(result.ok);
  EXPECT_EQ(result.num_used, 0);
  EXPECT_LT(testing::Difference(c.predicted, x).norm(), 1e-6);
  EXPECT_TRUE(result.covariance.allFinite());
}

TEST(FrameUpdateTest, LandmarksThatStandStillAgreeWithTheImu) {
  for (std::uint64_t seed = 400; seed < 420; ++seed) {
    const Case c = MakeCase(seed);
    FrameUpdater updater(c.rig, Options(), testing::DefaultBiasWalk());
    updater.SetReference(c.window, c.covariance, Noise());
    const InnovationTest test = updater.TestInnovations(c.observations, c.imu);
    EXPECT_GT(test.num_tested, 20);
    EXPECT_EQ(test.num_contradicting, 0) << seed;
    EXPECT_EQ(test.contradicts.size(), c.observations.size());
  }
}

TEST(FrameUpdateTest, ThoseThatMoveContradictIt) {
  Case c = MakeCase(421);
  FrameUpdater updater(c.rig, Options(), testing::DefaultBiasWalk());
  updater.SetReference(c.window, c.covariance, Noise());
  for (std::size_t k = 0; k < c.observations.size(); k += 2)
    testing::ShiftMeasurement({0, 0.15}, 0, c.observations[k].observation);
  const InnovationTest test = updater.TestInnovations(c.observations, c.imu);
  EXPECT_GT(test.num_contradicting, test.num_tested / 3);
  for (std::size_t k = 0; k < c.observations.size(); ++k) {
    if (k % 2 == 1) {
      EXPECT_FALSE(test.contradicts[k]) << k;
    }
  }
}

TEST(FrameUpdateTest, AWrongGyroscopeIsContradictedByNearlyAll) {
  const Case c = MakeCase(422);
  FrameUpdater updater(c.rig, Options(), testing::DefaultBiasWalk());
  updater.SetReference(c.window, c.covariance, Noise());
  ImuLink turned = c.imu;
  std::vector<ImuSample> samples = c.imu.measured.samples();
  for (ImuSample& sample : samples)
    sample.gyro.x() += 2;
  turned.measured = ImuPreintegration(c.imu.measured.bias(), {});
  turned.measured.Integrate(samples);
  const InnovationTest test = updater.TestInnovations(c.observations, turned);
  EXPECT_GT(test.num_contradicting, 0.8 * test.num_tested);
}

TEST(FrameUpdateTest, OutliersDoNotPull) {
  Case c = MakeCase(301);
  EstimatorOptions options;
  options.solver.frame_iterations = 5;
  const FactorNoise noise(options);
  FrameUpdater updater(c.rig, options.solver, testing::DefaultBiasWalk());
  updater.SetReference(c.window, c.covariance, noise);
  NavState clean = c.predicted, spoilt = c.predicted;
  updater.Update(c.observations, c.imu, noise, clean);
  for (std::size_t k = 0; k < c.observations.size(); k += 5)
    testing::ShiftMeasurement({0.2, 0}, 0, c.observations[k].observation);
  updater.Update(c.observations, c.imu, noise, spoilt);
  const Vector<15> sigma = c.joint_covariance.diagonal().cwiseSqrt();
  EXPECT_LT(testing::Difference(clean, spoilt).cwiseQuotient(sigma).head<9>().norm() / 3, 1.0);
}

}  // namespace
}  // namespace facet
