// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/linearized_window.h"

#include <gtest/gtest.h>

#include "facet/testing/estimator/balanced_prior.h"

namespace facet {
namespace {

using testing::TestWindow;

TEST(LinearizedWindowTest, CostIsTheSameWithAndWithoutLinearizing) {
  TestWindow test = testing::MakeOptimumWindow(52, 0);
  Rng rng(52);
  testing::AddBalancedPrior(test, rng, testing::kOptimumNoise);
  testing::Disturb(test.window, {}, rng);
  LinearizedWindow linear;
  testing::Linearize(test, testing::kOptimumNoise, linear);
  FrameGeometry geometry(test.rig);
  geometry.Update(test.window.frames);
  EXPECT_NEAR(
      WindowCost(test.window, geometry, testing::kOptimumNoise), linear.cost, 1e-9 * linear.cost);
}

std::vector<Variable> CoupledWith(int frame, const TestWindow& test) {
  LinearizedWindow linear;
  testing::Linearize(test, testing::kOptimumNoise, linear);
  std::vector<Variable> all, coupled;
  for (int k = 0; k < static_cast<int>(test.window.planes.size()); ++k)
    all.push_back(Variable::Plane(k));
  for (int i = 0; i <= test.window.newest_frame(); ++i) {
    all.push_back(Variable::Pose(i));
    all.push_back(Variable::Motion(i));
  }
  for (const Variable& variable : all) {
    if (linear.coupled_with_motion[static_cast<std::size_t>(frame)].Contains(variable))
      coupled.push_back(variable);
  }
  return coupled;
}

// The elimination of motions relies on it: no factor may touch a motion that is not listed.
TEST(LinearizedWindowTest, MotionsAreCoupledByTheFactorsOnThem) {
  Rng rng(53);
  TestWindow test = testing::MakeTestWindow({}, rng);
  SlidingWindow& window = test.window;
  window.planes.emplace_back(
      PlaneId{0}, Plane{Vector3d::UnitZ(), 1}, Vector3d::Zero(), testing::kPlaneSigma_m);
  using V = Variable;
  EXPECT_EQ(
      CoupledWith(1, test),
      (std::vector{V::Pose(0), V::Motion(0), V::Pose(1), V::Motion(1), V::Pose(2), V::Motion(2)}));
  EXPECT_EQ(CoupledWith(5, test),
            (std::vector{V::Pose(4), V::Motion(4), V::Pose(5), V::Motion(5)}));
  window.RemoveMotion(1);
  EXPECT_EQ(CoupledWith(0, test), std::vector{V::Pose(0)});
  window.prior.blocks = {MarginalPrior::Block::OfMotion(FrameId{0}, 0),
                         MarginalPrior::Block::OfPose(FrameId{3}, 9),
                         MarginalPrior::Block::OfPlane(PlaneId{0}, 15)};
  window.prior.H = MatrixXd::Identity(18, 18);
  window.prior.b = VectorXd::Zero(18);
  EXPECT_EQ(CoupledWith(0, test), (std::vector{V::Plane(0), V::Pose(0), V::Motion(0), V::Pose(3)}));
}

// What is settled has no columns; all others are as they were, with the same errors.
TEST(LinearizedWindowTest, SettledModesHaveNoColumns) {
  Rng rng(54);
  TestWindow test = testing::MakeTestWindow({}, rng);
  testing::AddCalibration(test, rng);
  LinearizedWindow with_modes, settled;
  testing::Linearize(test, testing::kOptimumNoise, with_modes);
  test.window.calibration->SettleModes(true);
  testing::Linearize(test, testing::kOptimumNoise, settled);
  const StateLayout& layout = settled.layout();
  ASSERT_EQ(layout.dim, with_modes.layout().dim);
  EXPECT_EQ(settled.cost, with_modes.cost);
  const int modes = layout.calibration_column + kLensModes;
  MatrixXd expected_H = with_modes.vision_H.selfadjointView<Eigen::Lower>();
  EXPECT_GT(expected_H.middleCols<2 * kNumLensModes>(modes).norm(), 1);
  expected_H.middleCols<2 * kNumLensModes>(modes).setZero();
  expected_H.middleRows<2 * kNumLensModes>(modes).setZero();
  VectorXd expected_b = with_modes.vision_b;
  expected_b.segment<2 * kNumLensModes>(modes).setZero();
  EXPECT_EQ(MatrixXd(settled.vision_H.selfadjointView<Eigen::Lower>()), expected_H);
  EXPECT_EQ(settled.vision_b, expected_b);
  for (int k = 0; k < settled.num_landmarks; ++k) {
    auto expected_W = with_modes.landmarks[static_cast<std::size_t>(k)].lens.front().W;
    expected_W.middleRows<2 * kNumLensModes>(kLensModes).setZero();
    EXPECT_EQ(settled.landmarks[static_cast<std::size_t>(k)].lens.front().W, expected_W);
  }
}

}  // namespace
}  // namespace facet
