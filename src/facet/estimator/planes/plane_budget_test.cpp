// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/planes/plane_budget.h"

#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

// Four planes, ids 10 to 13; one landmark lies on each of those in `supported`.
SlidingWindow WindowOfPlanes(const std::vector<int>& supported) {
  Rng rng(1);
  SlidingWindow window = testing::MakeTestWindow({}, rng).window;
  for (int k = 0; k < 4; ++k)
    window.planes.emplace_back(PlaneId{10 + k}, Plane{}, Vector3d::Zero(), testing::kPlaneSigma_m);
  for (int plane : supported)
    window.landmarks()[static_cast<std::size_t>(plane)].planes.Add(plane);
  return window;
}

std::vector<Matrix3d> Information(const std::vector<double>& values) {
  std::vector<Matrix3d> information;
  for (double value : values)
    information.push_back(value * Matrix3d::Identity());
  return information;
}

TEST(PlaneBudgetTest, NothingGoesWithinTheBudget) {
  EXPECT_TRUE(ExcessPlanes(WindowOfPlanes({}), Information({1, 2, 3, 4}), 4).empty());
  EXPECT_TRUE(ExcessPlanes(WindowOfPlanes({}), Information({1, 2, 3, 4}), 40).empty());
}

TEST(PlaneBudgetTest, TheLeastKnownGoes) {
  SlidingWindow window = WindowOfPlanes({0, 1, 2, 3});
  for (WindowPlane& plane : window.planes)
    plane.persistent = true;
  EXPECT_EQ(ExcessPlanes(window, Information({5, 2, 3, 4}), 3), std::vector{PlaneId{11}});
  EXPECT_EQ(ExcessPlanes(window, Information({5, 2, 3, 4}), 2),
            (std::vector{PlaneId{11}, PlaneId{12}}));
}

TEST(PlaneBudgetTest, AWellKnownPlaneStaysThoughItIsUnseen) {
  SlidingWindow window = WindowOfPlanes({1, 2});
  for (WindowPlane& plane : window.planes)
    plane.persistent = true;
  EXPECT_EQ(ExcessPlanes(window, Information({9, 1, 2, 8}), 2),
            (std::vector{PlaneId{11}, PlaneId{12}}));
}

// One in ten, at least one, and the best known of them.
TEST(PlaneBudgetTest, APlaneThatIsBeingDeterminedHasAChance) {
  SlidingWindow window = WindowOfPlanes({1, 2});
  window.planes[1].persistent = true;
  EXPECT_EQ(ExcessPlanes(window, Information({9, 3, 1, 8}), 3), std::vector{PlaneId{11}});
  window.planes[1].persistent = false;
  EXPECT_EQ(ExcessPlanes(window, Information({9, 3, 1, 8}), 3), std::vector{PlaneId{12}});
  EXPECT_EQ(ExcessPlanes(window, Information({9, 3, 1, 8}), 2),
            (std::vector{PlaneId{12}, PlaneId{13}}));
}

TEST(PlaneBudgetTest, ThePriorCounts) {
  SlidingWindow window = WindowOfPlanes({});
  window.prior.blocks.push_back(MarginalPrior::Block::OfPlane(PlaneId{11}, 0));
  window.prior.H = 100 * Matrix3d::Identity();
  window.prior.b = Vector3d::Zero();
  EXPECT_EQ(ExcessPlanes(window, Information({5, 2, 3, 4}), 3), std::vector{PlaneId{12}});
}

}  // namespace
}  // namespace facet
