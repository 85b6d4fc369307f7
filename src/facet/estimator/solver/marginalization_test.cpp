// SPDX-License-Identifier: BSD-2-Clause
// Marginalising is compared with the batch problem at one linearisation point, where both are the
// same linear algebra: what the remaining variables know, and where they would go, must not change.
#include "facet/estimator/solver/marginalization.h"

#include <algorithm>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "facet/estimator/factors/prior_factor.h"
#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

constexpr double kWidth = 2.0;

using testing::TestWindow;

// States off the optimum, start prior on the oldest frame.
TestWindow MakeWindow(std::uint64_t seed, int num_pose_frames = 0) {
  Rng rng(seed);
  testing::TestWindowOptions options;
  options.num_frames = 7;
  options.num_pose_frames = num_pose_frames;
  TestWindow test = testing::MakeTestWindow(options, rng);
  if (num_pose_frames == 0)
    test.window.start_prior.emplace(FrameId{0}, test.truth[0].T_WB, StartOptions{});
  testing::Disturb(test.window, {3e-4, 1e-3, 2e-3, 1e-4, 1e-3}, rng);
  return test;
}

// Landmarks with an observation in `frame`: every n-th goes with it, the others stay.
void DropSomeLandmarks(const SlidingWindow& window, int frame, int n, MarginalizationPlan& plan) {
  int count = 0;
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    for (const WindowObservation& o : window.landmarks()[l].observations) {
      if (o.frame == frame && count++ % n == 0) plan.drop_landmark[l] = 1;
    }
  }
}

// What the plan must leave of the batch problem: everything, but for the observations that
// landmarks which stay lose together with a frame.
SlidingWindow WithoutLostObservations(SlidingWindow window, const MarginalizationPlan& plan) {
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    if (plan.drop_landmark[l]) continue;
    WindowLandmark& landmark = window.landmarks()[l];
    std::erase_if(landmark.observations, [&](const auto& o) { return plan.drop_frame[o.frame]; });
    if (landmark.observations.empty()) continue;
    if (plan.drop_frame[landmark.host]) window.Rehost(landmark, landmark.observations[0].frame);
  }
  std::erase_if(window.measurements, [&](const PlaneMeasurement& measurement) {
    return plan.drop_plane[window.IndexOf(measurement.plane)] &&
           !plan.drop_frame[window.IndexOf(measurement.frame)];
  });
  return window;
}

// Columns of the variables of `window` that `after` still has, in the order of `after`.
std::vector<int> CommonColumns(const SlidingWindow& window, const SlidingWindow& after) {
  const StateLayout layout = MakeLayout(window), new_layout = MakeLayout(after);
  std::vector<int> columns(new_layout.dim);
  for (std::size_t k = 0; k < after.planes.size(); ++k) {
    const int old = window.IndexOf(after.planes[k].id);
    for (int c = 0; c < 3; ++c)
      columns[new_layout.plane_column[k] + c] = layout.plane_column[old] + c;
  }
  for (int k = 0; after.calibration && k < kNumCalibration; ++k)
    columns[new_layout.calibration_column + k] = layout.calibration_column + k;
  for (std::size_t i = 0; i < after.frames.size(); ++i) {
    const int old = window.IndexOf(after.frames[i].id);
    for (int k = 0; k < 6; ++k)
      columns[new_layout.pose_column[i] + k] = layout.pose_column[old] + k;
    if (!after.frames[i].has_motion) continue;
    for (int k = 0; k < 9; ++k)
      columns[new_layout.motion_column[i] + k] = layout.motion_column[old] + k;
  }
  return columns;
}

// Planes through random landmarks; every landmark near one lies on it.
void AddPlanes(TestWindow& test, int num_planes, std::uint64_t seed) {
  constexpr int kMinMembers = 10;  // fewer may leave the plane undetermined
  Rng rng(seed);
  const auto is_near = [&](const WindowLandmark& landmark, const Vector3d& n, const Vector3d& p_W) {
    return std::abs(n.dot(test.window.PositionOf(landmark) - p_W)) < 0.8;
  };
  for (int k = 0; k < num_planes;) {
    const Vector3d n = rng.UnitVector();
    const Vector3d& p_W = test.points[rng.Index(static_cast<int>(test.points.size()))];
    const auto& landmarks = test.window.landmarks();
    if (std::count_if(landmarks.begin(), landmarks.end(), [&](const WindowLandmark& l) {
          return is_near(l, n, p_W);
        }) < kMinMembers) {
      continue;
    }
    test.window.planes.emplace_back(
        PlaneId{k}, Plane{n, n.dot(p_W)}, Vector3d(p_W + rng.Normal3()), testing::kPlaneSigma_m);
    for (WindowLandmark& landmark : test.window.landmarks()) {
      if (is_near(landmark, n, p_W)) landmark.planes.Add(k);
    }
    for (const WindowFrame& frame : test.window.frames) {
      test.window.measurements.push_back(testing::MakeMeasurement(
          frame, test.window.planes.back(), p_W + rng.Normal3(), 0.1, rng));
    }
    ++k;
  }
}

// Largest difference in units of the standard deviations that the diagonal of H stands for.
double ScaledDifference(const MatrixXd& a, const MatrixXd& b) {
  const VectorXd s = b.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  return (s.asDiagonal() * (a - b) * s.asDiagonal()).cwiseAbs().maxCoeff();
}

// Newton step, on columns scaled to unit diagonal.
template <class Equations>
VectorXd StepOf(const Equations& system) {
  const VectorXd s = system.H.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = s.asDiagonal() * system.H * s.asDiagonal();
  return -s.cwiseProduct(scaled.ldlt().solve(s.cwiseProduct(system.b)));
}

void ExpectPositiveSemidefinite(const MarginalPrior& prior) {
  const VectorXd s = prior.H.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = s.asDiagonal() * prior.H * s.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled);
  EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-9 * eigen.eigenvalues().maxCoeff());
}

// Carries out the plan and compares information, gradient and step with the batch problem.
void ExpectMarginalizesLikeBatch(const MarginalizationPlan& plan, TestWindow& test) {
  const SlidingWindow batch_window = WithoutLostObservations(test.window, plan);
  const NormalEquations batch = testing::Assemble(batch_window, test.rig, kWidth);
  Marginalize(plan, test.rig, testing::NoiseOfWidth(kWidth), test.window);
  const std::vector<int> common = CommonColumns(batch_window, test.window);
  const testing::ReducedEquations expected = testing::ReduceTo(batch, common);
  const NormalEquations actual = testing::Assemble(test.window, test.rig, kWidth);
  ASSERT_EQ(actual.b.size(), expected.b.size());
  EXPECT_LT(ScaledDifference(actual.H, expected.H), 1e-8);
  const VectorXd s = expected.H.diagonal().cwiseSqrt().cwiseInverse();
  EXPECT_LT(s.cwiseProduct(actual.b - expected.b).norm(), 1e-7 * s.cwiseProduct(expected.b).norm());
  const VectorXd batch_step = StepOf(batch)(common);
  EXPECT_LT((StepOf(actual) - batch_step).norm(), 1e-7 * batch_step.norm());
  ExpectPositiveSemidefinite(test.window.prior);
}

TEST(MarginalizationTest, DroppedMotionEqualsBatch) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    TestWindow test = MakeWindow(seed);
    MarginalizationPlan plan(test.window);
    plan.drop_motion[0] = plan.drop_motion[1] = 1;
    ExpectMarginalizesLikeBatch(plan, test);
    EXPECT_FALSE(test.window.frames[0].has_motion);
    EXPECT_FALSE(test.window.frames[1].imu_link);
    EXPECT_FALSE(test.window.frames[2].imu_link);
    EXPECT_TRUE(test.window.frames[3].imu_link);
    EXPECT_TRUE(test.window.frames[2].motion_frozen);
    EXPECT_FALSE(test.window.frames[3].motion_frozen);
    EXPECT_FALSE(test.window.start_prior);
  }
}

TEST(MarginalizationTest, DroppedFrameWithLandmarksEqualsBatch) {
  for (std::uint64_t seed = 11; seed <= 20; ++seed) {
    TestWindow test = MakeWindow(seed);
    MarginalizationPlan plan(test.window);
    plan.drop_frame[0] = 1;
    DropSomeLandmarks(test.window, 0, 2, plan);
    ExpectMarginalizesLikeBatch(plan, test);
    EXPECT_EQ(test.window.frames.size(), 6u);
  }
}

TEST(MarginalizationTest, DroppedPoseInTheMiddleEqualsBatch) {
  for (std::uint64_t seed = 21; seed <= 30; ++seed) {
    TestWindow test = MakeWindow(seed, 3);
    // Something must fix the gauge for the comparison of steps: a prior on the first poses.
    test.window.prior.blocks = {MarginalPrior::Block::OfPose(FrameId{0}, 0),
                                MarginalPrior::Block::OfPose(FrameId{1}, 6)};
    test.window.prior.H = 1e6 * MatrixXd::Identity(12, 12);
    test.window.prior.b = VectorXd::Constant(12, 100.0);
    test.window.frames[0].pose_frozen = test.window.frames[1].pose_frozen = true;
    MarginalizationPlan plan(test.window);
    plan.drop_frame[1] = 1;
    DropSomeLandmarks(test.window, 1, 3, plan);
    ExpectMarginalizesLikeBatch(plan, test);
    EXPECT_EQ(test.window.IndexOf(FrameId{1}), -1);
  }
}

// Several marginalisations in a row, with steps of the whole window between them, so that the prior
// is used away from its linearisation point.
TEST(MarginalizationTest, ChainOfMarginalizationsEqualsBatchAtEveryLink) {
  for (std::uint64_t seed = 31; seed <= 35; ++seed) {
    TestWindow test = MakeWindow(seed);
    Rng rng(seed);
    for (int link = 0; link < 4; ++link) {
      MarginalizationPlan plan(test.window);
      if (link % 2 == 0) {
        plan.drop_motion[link / 2] = 1;
      } else {
        plan.drop_frame[0] = 1;
        plan.drop_motion[1] = test.window.frames[1].has_motion;
        DropSomeLandmarks(test.window, 0, 2, plan);
      }
      ExpectMarginalizesLikeBatch(plan, test);
      testing::Disturb(test.window, {1e-5, 1e-4, 1e-4, 1e-6, 1e-5}, rng);
      EXPECT_GT(PriorDelta(test.window).norm(), 0);
    }
  }
}

TEST(MarginalizationTest, WithPlanesEqualsBatchAtEveryLink) {
  for (std::uint64_t seed = 41; seed <= 50; ++seed) {
    TestWindow test = MakeWindow(seed);
    AddPlanes(test, 3, seed);
    Rng rng(seed);
    for (int link = 0; link < 3; ++link) {
      MarginalizationPlan plan(test.window);
      plan.drop_frame[0] = 1;
      plan.drop_motion[1] = test.window.frames[1].has_motion;
      DropSomeLandmarks(test.window, 0, 2, plan);
      ExpectMarginalizesLikeBatch(plan, test);
      testing::Disturb(test.window, {1e-5, 1e-4, 1e-4, 1e-6, 1e-5}, rng);
      for (WindowPlane& plane : test.window.planes)
        plane.ApplyStep(1e-4 * rng.Normal3());
    }
    EXPECT_EQ(test.window.planes.size(), 3u);
    EXPECT_TRUE(std::any_of(test.window.planes.begin(),
                            test.window.planes.end(),
                            [](const WindowPlane& plane) { return plane.frozen; }));
  }
}

TEST(MarginalizationTest, WithCalibrationAndPlanesEqualsBatchAtEveryLink) {
  for (std::uint64_t seed = 71; seed <= 76; ++seed) {
    TestWindow test = MakeWindow(seed);
    AddPlanes(test, 2, seed);
    Rng rng(seed);
    testing::AddCalibration(test, rng);
    for (int link = 0; link < 3; ++link) {
      MarginalizationPlan plan(test.window);
      plan.drop_frame[0] = 1;
      plan.drop_motion[1] = test.window.frames[1].has_motion;
      DropSomeLandmarks(test.window, 0, 2, plan);
      ExpectMarginalizesLikeBatch(plan, test);
      EXPECT_FALSE(test.window.calibration->start_information);
      testing::Disturb(test.window, {1e-5, 1e-4, 1e-4, 1e-6, 1e-5}, rng);
    }
  }
}

TEST(MarginalizationTest, ADroppedPlaneEqualsBatchOnceItsLandmarksAreGone) {
  TestWindow test = MakeWindow(51);
  AddPlanes(test, 2, 51);
  MarginalizationPlan frame(test.window);
  frame.drop_frame[0] = 1;
  for (std::size_t l = 0; l < test.window.landmarks().size(); ++l)
    frame.drop_landmark[l] = test.window.landmarks()[l].planes.Contains(0);
  Marginalize(frame, test.rig, testing::NoiseOfWidth(kWidth), test.window);
  ASSERT_TRUE(test.window.planes[0].frozen);
  MarginalizationPlan plane(test.window);
  plane.drop_plane[0] = 1;
  EXPECT_FALSE(plane.IsEmpty());
  ExpectMarginalizesLikeBatch(plane, test);
  ASSERT_EQ(test.window.planes.size(), 1u);
  EXPECT_EQ(test.window.planes[0].id, PlaneId{1});
}

// The relations of a leaving plane go into the prior, those of the others stay.
TEST(MarginalizationTest, ADroppedPlaneWithRelationsEqualsBatch) {
  using enum PlaneRelationKind;
  for (std::uint64_t seed = 52; seed <= 57; ++seed) {
    TestWindow test = MakeWindow(seed);
    AddPlanes(test, 3, seed);
    MarginalizationPlan frame(test.window);
    frame.drop_frame[0] = 1;
    for (std::size_t l = 0; l < test.window.landmarks().size(); ++l)
      frame.drop_landmark[l] = test.window.landmarks()[l].planes.Contains(0);
    Marginalize(frame, test.rig, testing::NoiseOfWidth(kWidth), test.window);
    ASSERT_TRUE(test.window.planes[0].frozen);
    const PlaneId a{0}, b{1}, c{2};
    for (const PlaneRelation& relation : {PlaneRelation{kCoplanar, a, b},
                                          PlaneRelation{kOrthogonal, c, a},
                                          PlaneRelation{kHorizontal, a},
                                          PlaneRelation{kParallel, b, c},
                                          PlaneRelation{kVertical, b},
                                          PlaneRelation{kHeadingParallel, a, c}}) {
      ASSERT_TRUE(test.window.AddRelation(relation));
    }
    Rng rng(seed);
    testing::Disturb(test.window, {1e-5, 1e-4, 1e-4, 1e-6, 1e-5}, rng);
    for (WindowPlane& plane : test.window.planes)
      plane.ApplyStep(1e-3 * rng.Normal3());
    MarginalizationPlan plane(test.window);
    plane.drop_plane[0] = 1;
    ExpectMarginalizesLikeBatch(plane, test);
    ASSERT_EQ(test.window.planes.size(), 2u);
    EXPECT_EQ(test.window.relations.size(), 2u);
    // What the relations touch is in the prior now.
    EXPECT_TRUE(test.window.planes[0].frozen && test.window.planes[1].frozen);
    EXPECT_TRUE(test.window.frames.back().pose_frozen);
  }
}

TEST(MarginalizationTest, OneByOneEqualsAllAtOnce) {
  TestWindow at_once = MakeWindow(36);
  TestWindow one_by_one = at_once;
  MarginalizationPlan both(at_once.window);
  both.drop_frame[0] = both.drop_frame[1] = 1;
  DropSomeLandmarks(at_once.window, 0, 1, both);
  DropSomeLandmarks(at_once.window, 1, 1, both);
  Marginalize(both, at_once.rig, testing::NoiseOfWidth(kWidth), at_once.window);
  // The landmarks of both frames go first: else those of the second would lose a row in between.
  MarginalizationPlan landmarks(one_by_one.window);
  landmarks.drop_landmark = both.drop_landmark;
  Marginalize(landmarks, one_by_one.rig, testing::NoiseOfWidth(kWidth), one_by_one.window);
  for (int k = 0; k < 2; ++k) {
    MarginalizationPlan plan(one_by_one.window);
    plan.drop_frame[0] = 1;
    Marginalize(plan, one_by_one.rig, testing::NoiseOfWidth(kWidth), one_by_one.window);
  }
  const auto a = testing::Assemble(at_once.window, at_once.rig, kWidth);
  const auto b = testing::Assemble(one_by_one.window, one_by_one.rig, kWidth);
  EXPECT_LT(ScaledDifference(a.H, b.H), 1e-9);
  EXPECT_LT((StepOf(a) - StepOf(b)).norm(), 1e-7 * StepOf(b).norm());
}

TEST(MarginalizationTest, EveryObservationIsUsedOrLostOnce) {
  TestWindow test = MakeWindow(37);
  const SlidingWindow before = test.window;
  MarginalizationPlan plan(before);
  plan.drop_frame[0] = 1;
  DropSomeLandmarks(before, 0, 2, plan);
  Marginalize(plan, test.rig, testing::NoiseOfWidth(kWidth), test.window);
  for (std::size_t l = 0; l < before.landmarks().size(); ++l) {
    const WindowLandmark& old = before.landmarks()[l];
    const WindowLandmark* now = test.window.Find(old.id);
    ASSERT_EQ(now == nullptr, plan.drop_landmark[l] != 0);
    if (now == nullptr) continue;
    const bool was_seen = old.observations[0].frame == 0;
    ASSERT_EQ(now->observations.size(), old.observations.size() - was_seen);
    for (std::size_t k = 0; k < now->observations.size(); ++k) {
      EXPECT_EQ(now->observations[k].frame, old.observations[k + was_seen].frame - 1);
      EXPECT_EQ(now->observations[k].rays[0].bearing,
                old.observations[k + was_seen].rays[0].bearing);
    }
    EXPECT_LT((testing::PointOf(test.window, *now) - testing::PointOf(before, old)).norm(), 1e-12);
  }
}

TEST(MarginalizationTest, FreezesExactlyWhatThePriorTouches) {
  TestWindow test = MakeWindow(38);
  MarginalizationPlan plan(test.window);
  plan.drop_frame[0] = 1;
  for (std::size_t l = 0; l < test.window.landmarks().size(); ++l) {
    // Landmarks seen in the two oldest frames only.
    plan.drop_landmark[l] = test.window.landmarks()[l].observations.back().frame <= 1;
  }
  const std::vector<WindowFrame> before = test.window.frames;
  Marginalize(plan, test.rig, testing::NoiseOfWidth(kWidth), test.window);
  EXPECT_EQ(test.window.prior.blocks.size(), 2u);
  EXPECT_EQ(test.window.prior.dim(), 15);
  EXPECT_TRUE(test.window.frames[0].pose_frozen && test.window.frames[0].motion_frozen);
  EXPECT_EQ(test.window.frames[0].delta.norm(), 0);
  for (std::size_t i = 1; i < test.window.frames.size(); ++i) {
    EXPECT_FALSE(test.window.frames[i].pose_frozen || test.window.frames[i].motion_frozen);
    EXPECT_EQ(testing::Difference(before[i + 1].x, test.window.frames[i].x).norm(), 0);
  }
}

TEST(MarginalizationTest, AnEmptyPlanChangesNothing) {
  TestWindow test = MakeWindow(39);
  const NormalEquations before = testing::Assemble(test.window, test.rig, kWidth);
  MarginalizationPlan plan(test.window);
  EXPECT_TRUE(plan.IsEmpty());
  Marginalize(plan, test.rig, testing::NoiseOfWidth(kWidth), test.window);
  EXPECT_TRUE(test.window.start_prior);
  EXPECT_EQ(testing::Assemble(test.window, test.rig, kWidth).H, before.H);
  plan.drop_motion[2] = 1;
  EXPECT_FALSE(plan.IsEmpty());
}

}  // namespace
}  // namespace facet
