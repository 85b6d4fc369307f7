// SPDX-License-Identifier: BSD-2-Clause
// The optimum of random windows against Ceres. With first-estimate Jacobians the stationary point
// moves when frozen variables leave their linearisation point; so the windows with a prior are made
// such that the optimum lies there (delta = 0), with a gradient of the prior that balances all
// other cost. Both solvers start elsewhere.
#include "facet/estimator/solver/window_solver.h"

#include <algorithm>
#include <iostream>
#include <utility>

#include <gtest/gtest.h>

#include "facet/estimator/planes/plane_membership.h"
#include "facet/testing/estimator/ceres_window.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

constexpr double kWidth = 10.0;

using testing::TestWindow;

SolverOptions ExactOptions() {
  SolverOptions options;
  options.loss_width = 0;  // the width stays what RobustOptions say
  options.min_cost_decrease = 0;
  return options;
}

TestWindow MakeWindow(std::uint64_t seed, int num_pose_frames) {
  Rng rng(seed);
  testing::TestWindowOptions options;
  options.num_frames = 5 + rng.Index(3);
  options.num_pose_frames = num_pose_frames;
  options.num_landmarks = 30;
  options.right_share = rng.Uniform(0.2, 0.8);
  options.outlier_share = 0.02;
  TestWindow test = testing::MakeTestWindow(options, rng);
  // A landmark that is seen once must not matter to anyone.
  test.window.landmarks().back().observations.resize(1);
  return test;
}

struct Deviation {
  double cost = 0, state = 0, point = 0, plane = 0;
};

Deviation Compare(const SlidingWindow& window, double cost, const testing::CeresResult& expected) {
  Deviation d;
  d.cost = std::abs(cost - expected.cost) / std::max(1.0, std::abs(expected.cost));
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    const Vector<15> difference = testing::Difference(window.frames[i].x, expected.states[i]);
    const int dim = window.frames[i].has_motion ? 15 : 6;
    d.state = std::max(d.state, difference.head(dim).cwiseAbs().maxCoeff());
  }
  for (std::size_t l = 0; l < expected.points.size(); ++l) {
    const WindowLandmark& landmark = window.landmarks()[l];
    if (!IsConstraining(landmark)) continue;
    const double error = (testing::PointOf(window, landmark) - expected.points[l]).norm();
    d.point = std::max(d.point, error / expected.points[l].norm());
  }
  for (std::size_t k = 0; k < window.planes.size(); ++k) {
    Vector4d plane;
    plane << window.planes[k].n, window.planes[k].offset;
    d.plane = std::max(d.plane, (plane - expected.planes[k]).norm());
  }
  return d;
}

void ExpectSmall(const Deviation& d, Deviation& worst) {
  EXPECT_LT(d.cost, 1e-6);
  EXPECT_LT(d.state, 1e-6);
  EXPECT_LT(d.point, 1e-5);
  EXPECT_LT(d.plane, 1e-5);
  worst = {std::max(worst.cost, d.cost),
           std::max(worst.state, d.state),
           std::max(worst.point, d.point),
           std::max(worst.plane, d.plane)};
}

void Print(const char* name, const Deviation& d) {
  std::cout << name << ": cost " << d.cost << ", states " << d.state << ", points " << d.point
            << ", planes " << d.plane << '\n';
}

TEST(WindowSolverTest, OptimumEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    TestWindow test = MakeWindow(seed, 0);
    test.window.start_prior = {true, FrameId{0}, test.truth[0].T_WB};
    test.window.start_prior.T_WB.p += Vector3d(0.1, -0.2, 0.3);
    Rng rng(seed);
    testing::Disturb(test.window, {}, rng);
    const auto expected = testing::SolveWithCeres(test.window, test.rig, {RobustOptions{kWidth}});
    WindowSolver solver(test.rig, ExactOptions(), RobustOptions{kWidth});
    const SolveSummary summary = solver.Solve(test.window, 100);
    EXPECT_TRUE(summary.ok);
    EXPECT_LT(summary.final_cost, summary.initial_cost);
    ExpectSmall(Compare(test.window, summary.final_cost, expected), worst);
  }
  Print("without prior", worst);
}

// With the flatness of scattered points, so that planes and loss matter but decide nothing.
RobustOptions WithPlanes() {
  RobustOptions robust{
      .reprojection_width = kWidth, .plane_sigma_m = 0.4, .plane_common_sigma_m = 0.1};
  robust.relations = {0.02, 0.03, 0.05, 2.0};
  return robust;
}

// Three planes through groups of landmarks, related in every way and sighted by every frame, and
// some landmarks of pipeline SP. The landmarks are moved onto the planes and observed anew, some a
// little beside them.
void AddPlanes(TestWindow& test, Rng& rng) {
  using enum PlaneRelationKind;
  SlidingWindow& window = test.window;
  const Vector3d centre_W = test.points[0];
  const Vector3d wall = ExpSO3({0, 0, rng.Uniform(-3, 3)}) * Vector3d::UnitX();
  const Vector3d normals[] = {Vector3d::UnitZ(), wall, -wall};
  for (int k = 0; k < 3; ++k) {
    const Vector3d n = ExpSO3(0.01 * rng.Normal3()) * normals[k];
    window.planes.emplace_back(
        PlaneId{k}, Plane{n, n.dot(centre_W)}, Vector3d(centre_W + 0.5 * rng.Normal3()));
  }
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    WindowLandmark& landmark = window.landmarks()[l];
    landmark.is_projection = l % 5 == 4;
    if (landmark.is_projection) continue;
    landmark.planes.Add(static_cast<int>(l % 3));
    if (l % 10 == 0) landmark.planes.Add(static_cast<int>((l + 1) % 3));
  }
  const PlaneId a{0}, b{1}, c{2};
  for (const PlaneRelation& relation : {PlaneRelation{kHorizontal, a},
                                        PlaneRelation{kVertical, b},
                                        PlaneRelation{kVertical, c},
                                        PlaneRelation{kOrthogonal, a, b},
                                        PlaneRelation{kCoplanar, c, b},
                                        PlaneRelation{kParallel, b, c},
                                        PlaneRelation{kHeadingParallel, b, c}}) {
    EXPECT_TRUE(window.AddRelation(relation));
  }
  for (const WindowFrame& frame : window.frames) {
    for (const WindowPlane& plane : window.planes) {
      window.sightings.push_back(
          testing::MakeSighting(frame, plane, centre_W + rng.Normal3(), 1.5, rng));
    }
  }
  WeighPlanes(WithPlanes(), window);
}

// Both solvers start from disturbed values.
void SolveBoth(TestWindow& test, Rng& rng, Deviation& worst) {
  test.window.start_prior = {true, FrameId{0}, test.truth[0].T_WB};
  testing::Disturb(test.window, {3e-3, 0.01, 0.01, 1e-3, 1e-3}, rng);
  const auto expected = testing::SolveWithCeres(test.window, test.rig, {WithPlanes()});
  WindowSolver solver(test.rig, ExactOptions(), WithPlanes());
  const SolveSummary summary = solver.Solve(test.window, 200);
  EXPECT_TRUE(summary.ok);
  ExpectSmall(Compare(test.window, summary.final_cost, expected), worst);
}

TEST(WindowSolverTest, OptimumWithPlanesRelationsAndProjectionsEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 71; seed <= 85; ++seed) {
    TestWindow test = MakeWindow(seed, 0);
    Rng rng(seed);
    AddPlanes(test, rng);
    SolveBoth(test, rng, worst);
  }
  Print("with planes", worst);
}

bool IsStereo(const WindowLandmark& landmark) {
  return std::any_of(landmark.observations.begin(),
                     landmark.observations.end(),
                     [](const WindowObservation& o) { return o.has_right; });
}

// Takes the right observations of every other landmark. Returns how many of those that constrain
// the window and are `of_kind` have none left, and how many still have some.
template <class Kind>
std::pair<int, int> MakeHalfOfThemMono(SlidingWindow& window, const Kind& of_kind) {
  int num_mono = 0, num_stereo = 0;
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    WindowLandmark& landmark = window.landmarks()[l];
    for (WindowObservation& observation : landmark.observations)
      observation.has_right &= l % 2 == 0;
    if (IsConstraining(landmark) && of_kind(landmark))
      ++(IsStereo(landmark) ? num_stereo : num_mono);
  }
  return {num_mono, num_stereo};
}

TEST(WindowSolverTest, OptimumOfMonoAndStereoLandmarksOnPlanesEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 111; seed <= 120; ++seed) {
    TestWindow test = MakeWindow(seed, 0);
    Rng rng(seed);
    AddPlanes(test, rng);
    const auto [num_mono, num_stereo] = MakeHalfOfThemMono(
        test.window, [](const WindowLandmark& landmark) { return landmark.IsOnPlanes(); });
    EXPECT_GE(num_mono, 8);
    EXPECT_GE(num_stereo, 8);
    SolveBoth(test, rng, worst);
  }
  Print("mono and stereo on planes", worst);
}

TEST(WindowSolverTest, OptimumOfMonoAndStereoProjectionFactorsEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 121; seed <= 130; ++seed) {
    TestWindow test = MakeWindow(seed, 0);
    Rng rng(seed);
    for (std::size_t l = 0; l < test.window.landmarks().size(); ++l)
      test.window.landmarks()[l].is_projection = l % 3 != 2;
    const auto [num_mono, num_stereo] = MakeHalfOfThemMono(
        test.window, [](const WindowLandmark& landmark) { return landmark.is_projection; });
    EXPECT_GE(num_mono, 6);
    EXPECT_GE(num_stereo, 6);
    SolveBoth(test, rng, worst);
  }
  Print("mono and stereo projections", worst);
}

// All landmarks leave, and with them the planes and what they are related to.
void LeavePlanes(TestWindow& test) {
  PlaneAssignments leave;
  for (const WindowLandmark& landmark : test.window.landmarks()) {
    for (const WindowPlane& plane : test.window.planes)
      leave.left.emplace_back(landmark.id, plane.id);
  }
  FrameGeometry geometry(test.rig);
  geometry.Update(test.window.frames);
  ApplyAssignments(leave, {}, WithPlanes(), geometry, test.window);
  test.window.sightings.clear();
  RemoveUnsupportedPlanes(1, test.window);
}

// The states are not the same to the last bit: the landmarks were on their planes for one solve, so
// that the next one begins elsewhere. It ends where it would have without planes.
TEST(WindowSolverTest, LandmarksThatLeaveTheirPlanesTakeTheirPullWithThem) {
  for (std::uint64_t seed = 131; seed <= 135; ++seed) {
    TestWindow never = MakeWindow(seed, 0);
    never.window.start_prior = {true, FrameId{0}, never.truth[0].T_WB};
    TestWindow left = never;
    Rng rng(seed);
    AddPlanes(left, rng);
    for (std::size_t l = 0; l < never.window.landmarks().size(); ++l)
      never.window.landmarks()[l].is_projection = left.window.landmarks()[l].is_projection;
    const auto solve = [](TestWindow& test) {
      return WindowSolver(test.rig, ExactOptions(), WithPlanes()).Solve(test.window, 200);
    };
    const auto distance = [&] {
      const NavState &a = never.window.frames.back().x, &b = left.window.frames.back().x;
      return testing::Difference(a, b).norm();
    };
    const double cost = solve(never).final_cost;
    solve(left);
    EXPECT_GT(distance(), 1e-4);
    LeavePlanes(left);
    EXPECT_TRUE(left.window.planes.empty());
    EXPECT_TRUE(left.window.relations.empty());
    EXPECT_NEAR(solve(left).final_cost, cost, 1e-6 * cost);
    EXPECT_LT(distance(), 1e-6);
  }
}

// Freezes the two oldest frames where they are and gives them a random prior of full rank whose
// gradient balances that of everything else at the optimum given the frozen frames.
void AddBalancedPrior(TestWindow& test,
                      Rng& rng,
                      const RobustOptions& robust = RobustOptions{kWidth}) {
  MarginalPrior& prior = test.window.prior;
  int dim = 0;
  for (std::size_t k = 0; k < test.window.planes.size(); k += 2) {
    test.window.planes[k].Freeze();
    prior.blocks.push_back({FrameId{}, false, dim, test.window.planes[k].id});
    dim += 3;
  }
  for (int i = 0; i < 2; ++i) {
    WindowFrame& frame = test.window.frames[i];
    frame.pose_frozen = true;
    prior.blocks.push_back({frame.id, false, dim});
    dim += 6;
    if (!frame.has_motion) continue;
    frame.motion_frozen = true;
    prior.blocks.push_back({frame.id, true, dim});
    dim += 9;
  }
  MatrixXd A(dim, dim);
  for (int r = 0; r < dim; ++r) {
    for (int c = 0; c < dim; ++c)
      A(r, c) = rng.Normal();
  }
  prior.H = 1e5 * (A * A.transpose() + MatrixXd::Identity(dim, dim));
  prior.b = VectorXd::Zero(dim);
  prior.b = -testing::SolveWithCeres(test.window, test.rig, {robust, true}).prior_gradient;
}

TEST(WindowSolverTest, OptimumWithPriorEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 21; seed <= 40; ++seed) {
    // Every other window has two frames without velocity and biases.
    TestWindow test = MakeWindow(seed, seed % 2 == 0 ? 2 : 0);
    Rng rng(seed);
    AddBalancedPrior(test, rng);
    EXPECT_GT(test.window.prior.b.norm(), 1);
    testing::Disturb(test.window, {3e-3, 0.01, 0.01, 1e-3, 1e-3}, rng);
    EXPECT_GT(PriorDelta(test.window).norm(), 1e-3);
    const auto expected = testing::SolveWithCeres(test.window, test.rig, {RobustOptions{kWidth}});
    WindowSolver solver(test.rig, ExactOptions(), RobustOptions{kWidth});
    const SolveSummary summary = solver.Solve(test.window, 100);
    EXPECT_TRUE(summary.ok);
    EXPECT_LT(PriorDelta(test.window).norm(), 1e-5);
    ExpectSmall(Compare(test.window, summary.final_cost, expected), worst);
  }
  Print("with prior", worst);
}

TEST(WindowSolverTest, OptimumWithPlanesInThePriorEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 91; seed <= 100; ++seed) {
    TestWindow test = MakeWindow(seed, seed % 2 == 0 ? 2 : 0);
    Rng rng(seed);
    AddPlanes(test, rng);
    AddBalancedPrior(test, rng, WithPlanes());
    testing::Disturb(test.window, {3e-3, 0.01, 0.01, 1e-3, 1e-3}, rng);
    for (WindowPlane& plane : test.window.planes)
      plane.ApplyStep(3e-3 * rng.Normal3());
    EXPECT_GT(PriorDelta(test.window).norm(), 1e-3);
    const auto expected = testing::SolveWithCeres(test.window, test.rig, {WithPlanes()});
    WindowSolver solver(test.rig, ExactOptions(), WithPlanes());
    const SolveSummary summary = solver.Solve(test.window, 200);
    EXPECT_TRUE(summary.ok);
    EXPECT_LT(PriorDelta(test.window).norm(), 1e-5);
    ExpectSmall(Compare(test.window, summary.final_cost, expected), worst);
  }
  Print("with planes in the prior", worst);
}

// Far from the linearisation point first-estimate Jacobians cost accuracy; how much is bounded
// here.
TEST(WindowSolverTest, AnUnbalancedPriorMovesTheOptimumOnlyToSecondOrder) {
  double worst = 0;
  for (std::uint64_t seed = 41; seed <= 45; ++seed) {
    TestWindow test = MakeWindow(seed, 0);
    Rng rng(seed);
    testing::Disturb(test.window, {5e-4, 2e-3, 2e-3, 1e-4, 1e-3}, rng);
    AddBalancedPrior(test, rng);
    test.window.prior.b.setZero();
    const auto expected = testing::SolveWithCeres(test.window, test.rig, {RobustOptions{kWidth}});
    SolverOptions options;
    options.loss_width = ExactOptions().loss_width;
    WindowSolver solver(test.rig, options, RobustOptions{kWidth});
    const SolveSummary summary = solver.Solve(test.window, 20);
    const Deviation d = Compare(test.window, summary.final_cost, expected);
    worst = std::max(worst, d.cost);
    EXPECT_LT(d.cost, 1e-2);
    EXPECT_GE(summary.final_cost, expected.cost * (1 - 1e-9));
  }
  std::cout << "cost above the optimum, relative: " << worst << '\n';
}

// Everything that the newest frame sees is far beyond the loss' width, but it is the frame that is
// wrong.
TEST(WindowSolverTest, APoorPredictionOfTheNewestFrameIsMended) {
  for (std::uint64_t seed = 51; seed <= 55; ++seed) {
    TestWindow test = MakeWindow(seed, 0);
    WindowFrame& newest = test.window.frames.back();
    newest.has_imu_link = newest.has_motion = false;
    newest.x.T_WB = newest.x.T_WB.Retract(Vector3d(0.05, -0.05, 0.05), Vector3d(0.1, 0.1, -0.1));
    WindowSystem system(test.rig);
    EXPECT_GT(system.NewestError(test.window), 10 * SolverOptions{}.loss_width);
    WindowSolver(test.rig, SolverOptions{}).Solve(test.window, 5);
    EXPECT_LT(system.NewestError(test.window), 2.0);
  }
}

TEST(WindowSystemTest, StartPriorGradientMatchesItsCost) {
  TestWindow test = MakeWindow(50, 0);
  Rng rng(50);
  test.window.start_prior = {true, FrameId{0}, test.truth[0].T_WB};
  test.window.start_prior.sigma_position = test.window.start_prior.sigma_yaw = 0.1;
  testing::Disturb(test.window, {0.4, 0.2, 0.2, 0.01, 0.1}, rng);
  const StateLayout layout = MakeLayout(test.window);
  MatrixXd H = MatrixXd::Zero(layout.dim, layout.dim);
  VectorXd b = VectorXd::Zero(layout.dim);
  AddStartPrior(test.window, layout, &H, &b);
  Matrix<1, 15> gradient;
  gradient << b.segment<6>(layout.pose_column[0]).transpose(),
      b.segment<9>(layout.motion_column[0]).transpose();
  const auto cost = [&](const Vector<15>& d) {
    SlidingWindow moved = test.window;
    moved.frames[0].x = testing::Retract(moved.frames[0].x, d);
    return Vector<1>(AddStartPrior(moved, layout, nullptr, nullptr));
  };
  testing::ExpectJacobian<1, 15>(gradient, cost, 1e-7);
}

// The system in which motions and landmarks are eliminated against the dense one.
TEST(WindowSystemTest, StepAndCovarianceEqualTheDenseSystem) {
  for (std::uint64_t seed = 51; seed < 56; ++seed) {
    TestWindow test = MakeWindow(seed, seed % 2 == 0 ? 2 : 0);
    Rng rng(seed);
    if (seed % 2 == 0) {
      AddBalancedPrior(test, rng);
    } else {
      test.window.start_prior = {true, FrameId{0}, test.truth[0].T_WB};
    }
    testing::Disturb(test.window, {1e-3, 0.01, 0.01, 1e-3, 1e-3}, rng);
    const testing::DenseSystem dense = testing::Assemble(test.window, test.rig, kWidth);
    const VectorXd s = dense.H.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd scaled = s.asDiagonal() * dense.H * s.asDiagonal();
    const MatrixXd inverse = s.asDiagonal() * scaled.inverse() * s.asDiagonal();
    WindowSystem system(test.rig);
    system.Linearize(test.window, RobustOptions{kWidth});
    ASSERT_TRUE(system.Solve(test.window, 0.0));
    const VectorXd step = -inverse * dense.b;
    EXPECT_LT((system.step() - step).norm(), 1e-6 * step.norm());
    const std::size_t newest = test.window.frames.size() - 1;
    std::vector<int> columns;
    for (int k = 0; k < 6; ++k)
      columns.push_back(dense.layout.pose_column[newest] + k);
    for (int k = 0; k < 9; ++k)
      columns.push_back(dense.layout.motion_column[newest] + k);
    const Matrix<15, 15> expected = inverse(columns, columns);
    const Vector<15> scale = expected.diagonal().cwiseSqrt().cwiseInverse();
    const Matrix<15, 15> error = system.NewestFrameCovariance() - expected;
    EXPECT_LT((scale.asDiagonal() * error * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST(WindowSystemTest, CostIsTheSameWithAndWithoutLinearizing) {
  TestWindow test = MakeWindow(52, 0);
  Rng rng(52);
  AddBalancedPrior(test, rng);
  testing::Disturb(test.window, {}, rng);
  WindowSystem system(test.rig);
  system.Linearize(test.window, RobustOptions{kWidth});
  EXPECT_NEAR(system.Cost(test.window, RobustOptions{kWidth}), system.cost(), 1e-9 * system.cost());
}

TEST(WindowSolverTest, CovarianceIsFreeOfDamping) {
  Rng rng(53);
  TestWindow test = MakeWindow(53, 0);
  AddBalancedPrior(test, rng);
  SolverOptions options;
  options.loss_width = 0;
  options.min_cost_decrease = 0;  // at the optimum the solver then damps until nothing moves
  WindowSolver solver(test.rig, options, RobustOptions{kWidth});
  solver.Solve(test.window, 30);
  const Matrix<15, 15> expected = [&] {
    WindowSystem system(test.rig);
    system.Linearize(test.window, RobustOptions{kWidth});
    EXPECT_TRUE(system.Solve(test.window, 1e-12));
    return system.NewestFrameCovariance();
  }();
  solver.Solve(test.window, 5);
  const Vector<15> scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix<15, 15> error = solver.NewestFrameCovariance(test.window) - expected;
  EXPECT_LT((scale.asDiagonal() * error * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(WindowSolverTest, NeverRaisesTheCost) {
  for (std::uint64_t seed = 60; seed < 70; ++seed) {
    TestWindow test = MakeWindow(seed, 0);
    test.window.start_prior = {true, FrameId{0}, test.truth[0].T_WB};
    Rng rng(seed);
    testing::Disturb(test.window, {0.1, 0.3, 1.0, 0.05, 0.5}, rng);
    SolverOptions options;
    options.loss_width = 0;
    WindowSolver solver(test.rig, options, RobustOptions{kWidth});
    const SolveSummary summary = solver.Solve(test.window, 10);
    EXPECT_TRUE(summary.ok);
    EXPECT_LE(summary.final_cost, summary.initial_cost);
    WindowSystem system(test.rig);
    system.Linearize(test.window, RobustOptions{kWidth});
    EXPECT_NEAR(system.cost(), summary.final_cost, 1e-9 * summary.final_cost);
  }
}

}  // namespace
}  // namespace facet
