// SPDX-License-Identifier: BSD-2-Clause
// The rows of measurements against numeric derivatives; that they know nothing of the gauge.
#include "facet/estimator/factors/plane_measurement_factor.h"

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_gauge.h"
#include "facet/testing/estimator/test_window.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

using testing::TestWindow;

constexpr double kNoLoss = 1e9;

// One plane, measured by the second frame. Everything is frozen and then moved by `moved`.
TestWindow MakeWindow(double noise, double moved, Rng& rng) {
  testing::TestWindowOptions options;
  options.num_frames = 3;
  options.num_landmarks = 5;
  TestWindow test = testing::MakeTestWindow(options, rng);
  SlidingWindow& window = test.window;
  const Vector3d n = rng.UnitVector(), p_W = 3 * rng.Normal3();
  window.planes.emplace_back(
      PlaneId{4}, Plane{n, n.dot(p_W)}, Vector3d(p_W + rng.Normal3()), testing::kPlaneSigma_m);
  window.measurements.push_back(testing::MakeMeasurement(
      window.frames[1], window.planes[0], Vector3d(p_W + rng.Normal3()), noise, rng));
  window.planes[0].Freeze();
  window.planes[0].ApplyStep(moved * rng.Normal3());
  for (WindowFrame& frame : window.frames) {
    frame.pose_frozen = true;
    frame.ApplyStep(moved * testing::RandomStep({1, 1, 1, 1, 1}, rng));
  }
  return test;
}

PlaneMeasurementRows Linearize(const SlidingWindow& window, double huber_sigma) {
  return PlaneMeasurementFactor(window, window.measurements[0], huber_sigma).Linearize();
}

Vector3d ErrorAfter(SlidingWindow window, const Vector<9>& step) {
  window.planes[0].ApplyStep(step.head<3>());
  Vector<15> frame_step = Vector<15>::Zero();
  frame_step.head<6>() = step.tail<6>();
  window.frames[1].ApplyStep(frame_step);
  return PlaneMeasurementFactor(window, window.measurements[0], kNoLoss).Error();
}

TEST(PlaneMeasurementFactorTest, JacobiansMatchNumericDerivatives) {
  Rng rng(1);
  for (int run = 0; run < 20; ++run) {
    const TestWindow test = MakeWindow(2, 0.0, rng);
    const PlaneMeasurementRows rows = Linearize(test.window, kNoLoss);
    Matrix<3, 9> J;
    J << rows.J_plane, rows.J_pose;
    testing::ExpectJacobian<3, 9>(
        J, [&](const Vector<9>& d) { return ErrorAfter(test.window, d); }, 1e-7);
    EXPECT_LT((rows.r - ErrorAfter(test.window, Vector<9>::Zero())).norm(), 1e-12);
    EXPECT_NEAR(rows.cost, 0.5 * rows.r.squaredNorm(), 1e-9 * (1 + rows.cost));
  }
}

TEST(PlaneMeasurementFactorTest, AnExactMeasurementHasNoError) {
  Rng rng(2);
  const TestWindow test = MakeWindow(0, 0.0, rng);
  EXPECT_LT(Linearize(test.window, kNoLoss).r.norm(), 1e-9);
}

// However far the estimate is from the point of linearisation.
TEST(PlaneMeasurementFactorTest, RowsKnowNothingOfPositionAndHeading) {
  Rng rng(3);
  for (int run = 0; run < 20; ++run) {
    const TestWindow test = MakeWindow(2, 0.1, rng);
    const SlidingWindow& window = test.window;
    NormalEquations equations;
    equations.Clear(window);
    PlaneMeasurementFactor(window, window.measurements[0], kNoLoss).AddTo(equations);
    const auto& [layout, H, b] = equations;
    EXPECT_LT((H - H.transpose()).norm(), 1e-9 * H.norm());
    const MatrixXd N = testing::WindowDirections(window, 3 * rng.Normal3());
    EXPECT_LT((N.transpose() * b).norm(), 1e-10 * (1 + b.norm()));
    EXPECT_LT((N.transpose() * H * N).diagonal().cwiseAbs().maxCoeff(),
              1e-13 * (1 + H.diagonal().maxCoeff()));
  }
}

TEST(PlaneMeasurementFactorTest, FarOffTheyPullNoHarderThanTheLossAllows) {
  Rng rng(4);
  TestWindow test = MakeWindow(0, 0.0, rng);
  test.window.planes[0].offset += 100 * test.window.measurements[0].sigma_m;
  const PlaneMeasurementRows rows = Linearize(test.window, 2);
  EXPECT_NEAR(rows.cost, 2 * (100 - 1), 1e-6);
  EXPECT_NEAR((rows.J_plane.transpose() * rows.r).norm(),
              2 * Linearize(test.window, kNoLoss).J_plane.row(0).norm(),
              1e-6 * rows.J_plane.norm());
}

}  // namespace
}  // namespace facet
