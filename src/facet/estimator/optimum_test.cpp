// SPDX-License-Identifier: BSD-2-Clause
// The optimum of random windows, with planes and without, against Ceres. Both solvers start
// elsewhere.
#include <algorithm>
#include <iostream>
#include <utility>

#include <gtest/gtest.h>

#include "facet/estimator/factors/prior_factor.h"
#include "facet/estimator/planes/plane_membership.h"
#include "facet/estimator/solver/window_solver.h"
#include "facet/geometry/so3.h"
#include "facet/testing/estimator/balanced_prior.h"

namespace facet {
namespace {

using testing::TestWindow;

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

TEST(OptimumTest, OptimumEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    TestWindow test = testing::MakeOptimumWindow(seed, 0);
    test.window.start_prior.emplace(FrameId{0}, test.truth[0].T_WB, StartOptions{});
    test.window.start_prior->T_WB.p += Vector3d(0.1, -0.2, 0.3);
    Rng rng(seed);
    testing::Disturb(test.window, {}, rng);
    const auto expected = testing::SolveWithCeres(test.window, test.rig, {testing::kOptimumNoise});
    WindowSolver solver(test.rig, testing::ExactOptions());
    const SolveSummary summary = solver.Solve(test.window, testing::kOptimumNoise, 100);
    EXPECT_TRUE(summary.ok);
    EXPECT_LT(summary.final_cost, *summary.initial_cost);
    ExpectSmall(Compare(test.window, summary.final_cost, expected), worst);
  }
  Print("without prior", worst);
}

// With the flatness of scattered points, so that planes and loss matter but decide nothing.
FactorNoise WithPlanes() {
  FactorNoise noise = testing::kOptimumNoise;
  noise.plane_sigma_m = 0.4;
  noise.plane_common_sigma_m = 0.1;
  noise.relations.sigma_rad = 0.02;
  noise.relations.gravity_sigma_rad = 0.03;
  noise.relations.sigma_m = 0.05;
  noise.relations.huber_sigma = 2.0;
  return noise;
}

// Three planes through groups of landmarks, related in every way and measured by every frame, and
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
    window.planes.emplace_back(PlaneId{k},
                               Plane{n, n.dot(centre_W)},
                               Vector3d(centre_W + 0.5 * rng.Normal3()),
                               testing::kPlaneSigma_m);
  }
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    WindowLandmark& landmark = window.landmarks()[l];
    landmark.is_projection = l % 5 == 4;
    if (landmark.is_projection) continue;
    landmark.planes.Add(static_cast<int>(l % 3), l % 5 == 0 ? 3.0 : 1.0);
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
      window.measurements.push_back(
          testing::MakeMeasurement(frame, plane, centre_W + rng.Normal3(), 1.5, rng));
    }
  }
  WeighPlanes(WithPlanes(), window);
}

// Both solvers start from disturbed values.
void SolveBoth(TestWindow& test, Rng& rng, Deviation& worst) {
  test.window.start_prior.emplace(FrameId{0}, test.truth[0].T_WB, StartOptions{});
  testing::Disturb(test.window, {3e-3, 0.01, 0.01, 1e-3, 1e-3}, rng);
  const auto expected = testing::SolveWithCeres(test.window, test.rig, {WithPlanes()});
  WindowSolver solver(test.rig, testing::ExactOptions());
  const SolveSummary summary = solver.Solve(test.window, WithPlanes(), 200);
  EXPECT_TRUE(summary.ok);
  ExpectSmall(Compare(test.window, summary.final_cost, expected), worst);
}

TEST(OptimumTest, OptimumWithPlanesRelationsAndProjectionsEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 71; seed <= 85; ++seed) {
    TestWindow test = testing::MakeOptimumWindow(seed, 0);
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

TEST(OptimumTest, OptimumOfMonoAndStereoLandmarksOnPlanesEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 111; seed <= 120; ++seed) {
    TestWindow test = testing::MakeOptimumWindow(seed, 0);
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

TEST(OptimumTest, OptimumOfMonoAndStereoProjectionFactorsEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 121; seed <= 130; ++seed) {
    TestWindow test = testing::MakeOptimumWindow(seed, 0);
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
      leave.detached.emplace_back(landmark.id, plane.id);
  }
  FrameGeometry geometry(test.rig);
  geometry.Update(test.window.frames);
  ApplyAssignments(leave, AttachmentLimits{}, WithPlanes(), geometry, PlaneEvidence(), test.window);
  test.window.measurements.clear();
  RemoveSparsePlanes(1, test.window);
}

// The states are not the same to the last bit: the landmarks were on their planes for one solve, so
// that the next one begins elsewhere. It ends where it would have without planes.
TEST(OptimumTest, LandmarksThatLeaveTheirPlanesTakeTheirPullWithThem) {
  for (std::uint64_t seed = 131; seed <= 135; ++seed) {
    TestWindow never = testing::MakeOptimumWindow(seed, 0);
    never.window.start_prior.emplace(FrameId{0}, never.truth[0].T_WB, StartOptions{});
    TestWindow left = never;
    Rng rng(seed);
    AddPlanes(left, rng);
    for (std::size_t l = 0; l < never.window.landmarks().size(); ++l)
      never.window.landmarks()[l].is_projection = left.window.landmarks()[l].is_projection;
    const auto solve = [](TestWindow& test) {
      return WindowSolver(test.rig, testing::ExactOptions()).Solve(test.window, WithPlanes(), 200);
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

TEST(OptimumTest, OptimumWithPriorEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 21; seed <= 40; ++seed) {
    // Every other window has two frames without velocity and biases.
    TestWindow test = testing::MakeOptimumWindow(seed, seed % 2 == 0 ? 2 : 0);
    Rng rng(seed);
    testing::AddBalancedPrior(test, rng, testing::kOptimumNoise);
    EXPECT_GT(test.window.prior.b.norm(), 1);
    testing::Disturb(test.window, {3e-3, 0.01, 0.01, 1e-3, 1e-3}, rng);
    EXPECT_GT(PriorDelta(test.window).norm(), 1e-3);
    const auto expected = testing::SolveWithCeres(test.window, test.rig, {testing::kOptimumNoise});
    WindowSolver solver(test.rig, testing::ExactOptions());
    const SolveSummary summary = solver.Solve(test.window, testing::kOptimumNoise, 100);
    EXPECT_TRUE(summary.ok);
    EXPECT_LT(PriorDelta(test.window).norm(), 1e-5);
    ExpectSmall(Compare(test.window, summary.final_cost, expected), worst);
  }
  Print("with prior", worst);
}

TEST(OptimumTest, OptimumWithPlanesInThePriorEqualsCeres) {
  Deviation worst;
  for (std::uint64_t seed = 91; seed <= 100; ++seed) {
    TestWindow test = testing::MakeOptimumWindow(seed, seed % 2 == 0 ? 2 : 0);
    Rng rng(seed);
    AddPlanes(test, rng);
    testing::AddBalancedPrior(test, rng, WithPlanes());
    testing::Disturb(test.window, {3e-3, 0.01, 0.01, 1e-3, 1e-3}, rng);
    for (WindowPlane& plane : test.window.planes)
      plane.ApplyStep(3e-3 * rng.Normal3());
    EXPECT_GT(PriorDelta(test.window).norm(), 1e-3);
    const auto expected = testing::SolveWithCeres(test.window, test.rig, {WithPlanes()});
    WindowSolver solver(test.rig, testing::ExactOptions());
    const SolveSummary summary = solver.Solve(test.window, WithPlanes(), 200);
    EXPECT_TRUE(summary.ok);
    EXPECT_LT(PriorDelta(test.window).norm(), 1e-5);
    ExpectSmall(Compare(test.window, summary.final_cost, expected), worst);
  }
  Print("with planes in the prior", worst);
}

// Far from the linearisation point first-estimate Jacobians cost accuracy; how much is bounded
// here.
TEST(OptimumTest, AnUnbalancedPriorMovesTheOptimumOnlyToSecondOrder) {
  double worst = 0;
  for (std::uint64_t seed = 41; seed <= 45; ++seed) {
    TestWindow test = testing::MakeOptimumWindow(seed, 0);
    Rng rng(seed);
    testing::Disturb(test.window, {5e-4, 2e-3, 2e-3, 1e-4, 1e-3}, rng);
    testing::AddBalancedPrior(test, rng, testing::kOptimumNoise);
    test.window.prior.b.setZero();
    const auto expected = testing::SolveWithCeres(test.window, test.rig, {testing::kOptimumNoise});
    SolverOptions options;
    options.loss_width = testing::ExactOptions().loss_width;
    WindowSolver solver(test.rig, options);
    const SolveSummary summary = solver.Solve(test.window, testing::kOptimumNoise, 20);
    const Deviation d = Compare(test.window, summary.final_cost, expected);
    worst = std::max(worst, d.cost);
    EXPECT_LT(d.cost, 1e-2);
    EXPECT_GE(summary.final_cost, expected.cost * (1 - 1e-9));
  }
  std::cout << "cost above the optimum, relative: " << worst << '\n';
}

}  // namespace
}  // namespace facet
