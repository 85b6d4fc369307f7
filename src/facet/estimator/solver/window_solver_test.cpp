// SPDX-License-Identifier: BSD-2-Clause
// The loop; that it finds the optimum is tested in optimum_test.
#include "facet/estimator/solver/window_solver.h"

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/testing/estimator/balanced_prior.h"

namespace facet {
namespace {

using testing::TestWindow;

// Everything that the newest frame sees is far beyond the loss' width, but it is the frame that is
// wrong.
TEST(WindowSolverTest, APoorPredictionOfTheNewestFrameIsMended) {
  for (std::uint64_t seed = 51; seed <= 55; ++seed) {
    TestWindow test = testing::MakeOptimumWindow(seed, 0);
    WindowFrame& newest = test.window.frames.back();
    newest.imu_link.reset();
    newest.has_motion = false;
    newest.x.T_WB = newest.x.T_WB.Retract(Vector3d(0.05, -0.05, 0.05), Vector3d(0.1, 0.1, -0.1));
    WindowSolver solver(test.rig, SolverOptions{});
    EXPECT_GT(solver.NewestFrameError(test.window), 10 * SolverOptions{}.loss_width);
    solver.Solve(test.window, FactorNoise(EstimatorOptions{}), 5);
    EXPECT_LT(solver.NewestFrameError(test.window), 2.0);
  }
}

TEST(WindowSolverTest, CovarianceIsFreeOfDamping) {
  Rng rng(53);
  TestWindow test = testing::MakeOptimumWindow(53, 0);
  testing::AddBalancedPrior(test, rng, testing::kOptimumNoise);
  SolverOptions options;
  options.loss_width = 0;
  options.min_cost_decrease = 0;  // at the optimum the solver then damps until nothing moves
  WindowSolver solver(test.rig, options);
  solver.Solve(test.window, testing::kOptimumNoise, 30);
  const Matrix<15, 15> expected = [&] {
    LinearizedWindow linear;
    ReducedSystem reduced;
    testing::Linearize(test, testing::kOptimumNoise, linear);
    EXPECT_TRUE(reduced.Solve(1e-12, linear));
    return NewestFrameCovariance(reduced, linear.layout());
  }();
  solver.Solve(test.window, testing::kOptimumNoise, 5);
  const Vector<15> scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix<15, 15> error = solver.NewestFrameCovariance() - expected;
  EXPECT_LT((scale.asDiagonal() * error * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(WindowSolverTest, LandmarksKeepWhatIsKnownOfThem) {
  Rng rng(54);
  TestWindow test = testing::MakeOptimumWindow(54, 0);
  testing::AddBalancedPrior(test, rng, testing::kOptimumNoise);
  testing::Disturb(test.window, {1e-4, 1e-3, 1e-3, 1e-4, 1e-4}, rng);
  WindowSolver solver(test.rig, SolverOptions{});
  solver.Solve(test.window, testing::kOptimumNoise, 5);
  FrameGeometry geometry(test.rig);
  geometry.Update(test.window);
  int num_known = 0;
  for (const WindowLandmark& landmark : test.window.landmarks()) {
    if (!IsConstraining(landmark)) continue;
    LandmarkBlock block;
    LinearizeLandmark(geometry, test.window.planes, landmark, testing::kOptimumNoise, block);
    const LandmarkInformation& known = landmark.information;
    EXPECT_LT((known.V - block.V).norm(), 0.02 * block.V.norm());
    EXPECT_LT((known.basis_H - TangentBasis(landmark.bearing_H)).norm(), 1e-3);
    EXPECT_EQ(known.num_rows, CountRows(landmark));
    ++num_known;
  }
  EXPECT_GT(num_known, 20);
  WindowLandmark landmark = test.window.landmarks().front();
  landmark.observations.front().has_right = !landmark.observations.front().has_right;
  EXPECT_NE(landmark.information.num_rows, CountRows(landmark)) << "it has lost or won a camera";
  test.window.Rehost(landmark, landmark.observations.back().frame);
  EXPECT_EQ(landmark.information.num_rows, 0) << "of directions in another frame";
}

TEST(WindowSolverTest, NeverRaisesTheCost) {
  for (std::uint64_t seed = 60; seed < 70; ++seed) {
    TestWindow test = testing::MakeOptimumWindow(seed, 0);
    test.window.start_prior.emplace(FrameId{0}, test.truth[0].T_WB, StartOptions{});
    Rng rng(seed);
    testing::Disturb(test.window, {0.1, 0.3, 1.0, 0.05, 0.5}, rng);
    SolverOptions options;
    options.loss_width = 0;
    WindowSolver solver(test.rig, options);
    const SolveSummary summary = solver.Solve(test.window, testing::kOptimumNoise, 10);
    EXPECT_TRUE(summary.ok);
    EXPECT_LE(summary.final_cost, summary.initial_cost);
    LinearizedWindow linear;
    testing::Linearize(test, testing::kOptimumNoise, linear);
    EXPECT_NEAR(linear.cost, summary.final_cost, 1e-9 * summary.final_cost);
  }
}

// Planes that nothing but a relation knows: the rest of the window does not notice them.
TEST(WindowSolverTest, PlanesWithoutLandmarksBreakNothing) {
  using enum PlaneRelationKind;
  Rng rng(9);
  testing::TestWindowOptions options;
  TestWindow test = testing::MakeTestWindow(options, rng);
  test.window.start_prior.emplace(FrameId{0}, test.truth[0].T_WB, StartOptions{});
  testing::Disturb(test.window, {1e-3, 0.01, 0.01, 1e-3, 1e-3}, rng);
  SlidingWindow with = test.window;
  // Walls that nearly face each other.
  const Vector3d n_a = ExpSO3(0.02 * rng.Normal3()) * Vector3d::UnitX();
  const Vector3d n_b = ExpSO3(0.02 * rng.Normal3()) * Vector3d(-1, 0, 0);
  with.planes.emplace_back(PlaneId{4}, Plane{n_a, 1}, rng.Normal3(), testing::kPlaneSigma_m);
  with.planes.emplace_back(PlaneId{7}, Plane{n_b, 2}, rng.Normal3(), testing::kPlaneSigma_m);
  for (const PlaneRelationKind kind : {kHeadingParallel, kVertical, kCoplanar})
    EXPECT_TRUE(with.AddRelation({kind, PlaneId{4}, PlaneId{7}}));
  SolverOptions solver_options;
  solver_options.min_cost_decrease = 0;
  const FactorNoise noise{EstimatorOptions{}};
  WindowSolver plain(test.rig, solver_options), related(test.rig, solver_options);
  EXPECT_TRUE(plain.Solve(test.window, noise, 20).ok);
  EXPECT_TRUE(related.Solve(with, noise, 20).ok);
  for (std::size_t i = 0; i < with.frames.size(); ++i) {
    EXPECT_LT(testing::Difference(with.frames[i].x, test.window.frames[i].x).norm(), 1e-6);
  }
  const Matrix<15, 15> difference = related.NewestFrameCovariance() - plain.NewestFrameCovariance();
  EXPECT_LT(difference.norm(), 1e-3 * plain.NewestFrameCovariance().norm());
}

// While everything that the newest frame sees is off, lenses that could move would take their
// share.
TEST(WindowSolverTest, TheCalibrationIsHeldUntilTheNewestFrameIsWhereItBelongs) {
  for (std::uint64_t seed = 81; seed < 85; ++seed) {
    Rng rng(seed);
    TestWindow test = testing::MakeOptimumWindow(seed, 0);
    testing::AddCalibration(test, rng);
    test.window.start_prior.emplace(FrameId{0}, test.truth[0].T_WB, StartOptions{});
    const auto solved = [&](double off, int max_iterations) {
      SlidingWindow window = test.window;
      WindowFrame& newest = window.frames.back();
      newest.x.T_WB = newest.x.T_WB.Retract(off * Vector3d(1, -1, 1), off * Vector3d(3, 3, -3));
      WindowSolver solver(test.rig, SolverOptions{});
      EXPECT_TRUE(solver.Solve(window, FactorNoise(EstimatorOptions{}), max_iterations).ok);
      const CalibrationVector sigmas = solver.CalibrationCovariance().diagonal().cwiseSqrt();
      return CalibrationVector(window.calibration->delta().cwiseQuotient(sigmas));
    };
    const CalibrationVector optimum = solved(0, 30);
    EXPECT_LT((solved(0.05, 2) - optimum).norm(), 0.3 * (solved(0.05, 1) - optimum).norm());
  }
}

}  // namespace
}  // namespace facet
