// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/start/segments.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

// A body that flies level and straight on, at 0.5 m/s along x, and turns about the vertical.
class SegmentsTest : public ::testing::Test {
 protected:
  static constexpr double kTurn = 0.3;  // rad/s

  SegmentsTest() { x_.v_WB = Vector3d(0.5, 0, 0); }

  ImuLink Link(double seconds, double accel_x = 0) const {
    ImuLink link;
    std::vector<ImuSample> samples;
    for (int i = 0; i <= static_cast<int>(seconds * 200); ++i) {
      const Timestamp t = x_.t + FromSeconds(i / 200.0);
      samples.push_back({t, Vector3d(0, 0, kTurn), Vector3d(accel_x, 0, kGravity)});
    }
    link.measured = ImuPreintegration({}, ImuParameters());
    link.measured.Integrate(samples);
    return link;
  }

  static Matrix<15, 15> Small() { return 1e-6 * Matrix<15, 15>::Identity(); }

  Segments segments_{testing::DefaultBiasWalk()};
  NavState x_;
};

TEST_F(SegmentsTest, TheFirstOneIsTheWorld) {
  EXPECT_FALSE(segments_.PredictedPose());
  segments_.End(nullptr);  // lost before anything was known
  EXPECT_FALSE(segments_.is_between());
  EXPECT_FALSE(segments_.PredictedPose());
  segments_.Begin(x_);
  EXPECT_EQ(segments_.id(), 0);
  EXPECT_EQ(segments_.InWorld(Small(), x_), Small());
}

TEST_F(SegmentsTest, ANewOneBeginsWhereTheImuLeads) {
  segments_.Begin(x_);
  segments_.Keep(x_, Small(), true);
  const ImuLink link = Link(1);
  segments_.End(&link);
  EXPECT_TRUE(segments_.is_between());
  segments_.Follow(Link(0.5));
  ASSERT_TRUE(segments_.PredictedPose());
  const SE3 T_WB = *segments_.PredictedPose();
  EXPECT_LT((T_WB.p - Vector3d(0.75, 0, 0)).norm(), 1e-6);
  EXPECT_LT(T_WB.q.angularDistance(ExpSO3({0, 0, 1.5 * kTurn})), 1e-6);
}

TEST_F(SegmentsTest, AllOfItIsAsUncertainAsItsBeginning) {
  segments_.Begin(x_);
  segments_.Keep(x_, Small(), true);
  const ImuLink link = Link(3);
  segments_.End(&link);
  const SE3 predicted = *segments_.PredictedPose();
  NavState begin;
  begin.T_WB = predicted;
  segments_.Begin(begin);
  EXPECT_EQ(segments_.id(), 1);
  EXPECT_FALSE(segments_.is_between());
  const Matrix<15, 15> at_begin = segments_.InWorld(Small(), begin);
  const double sigma_p = std::sqrt(at_begin(4, 4));
  EXPECT_GT(sigma_p, 0.01);
  const double sigma_yaw = std::sqrt(at_begin(2, 2));
  EXPECT_GT(sigma_yaw, 1e-3);
  EXPECT_NEAR(at_begin(0, 0), Small()(0, 0), 1e-12) << "gravity tells the tilt";
  // Ten metres on, the heading moves the position.
  NavState far = begin;
  far.T_WB.p.x() += 10;
  const Matrix<15, 15> at_far = segments_.InWorld(Small(), far);
  EXPECT_GT(std::sqrt(at_far(4, 4)), 0.9 * std::hypot(sigma_p, 10 * sigma_yaw) - sigma_p);
  EXPECT_NEAR(at_far(2, 2), at_begin(2, 2), 1e-12);
}

TEST_F(SegmentsTest, ABrokenImuIsNotFollowed) {
  segments_.Begin(x_);
  segments_.Keep(x_, Small(), true);
  const ImuLink link = Link(1, 500.0);
  segments_.End(&link);
  EXPECT_LT((segments_.PredictedPose()->p - x_.T_WB.p).norm(), 1e-9) << "where it was lost";
  segments_.Follow(Link(2, 500.0));
  NavState begin;
  begin.T_WB = *segments_.PredictedPose();
  segments_.Begin(begin);
  const Matrix<15, 15> covariance = segments_.InWorld(Small(), begin);
  EXPECT_NEAR(std::sqrt(covariance(3, 3)), 15, 0.1);  // 5 m/s for 3 s
  EXPECT_GT(std::sqrt(covariance(2, 2)), 90 * kDegree);
}

// A clock that jumps by centuries: variances of kilometres squared times 1e50 would drown the
// others.
TEST_F(SegmentsTest, UncertaintyStaysAVarianceHoweverLongItLasts) {
  segments_.Begin(x_);
  segments_.Keep(x_, Small(), true);
  ImuLink link;
  link.measured = ImuPreintegration({}, ImuParameters());
  const ImuSample first{x_.t, {0.3, 0.2, 0.1}, {0.1, 0, kGravity}};
  ImuSample last = first;
  last.t = x_.t + FromSeconds(9e9);
  link.measured.Integrate(std::vector<ImuSample>{first, last});
  segments_.End(&link);
  NavState begin;
  begin.T_WB = *segments_.PredictedPose();
  segments_.Begin(begin);
  const Matrix<15, 15> covariance = segments_.InWorld(Small(), begin);
  EXPECT_TRUE(covariance.allFinite());
  EXPECT_GE(covariance.diagonal().minCoeff(), 0.99e-6);
  EXPECT_LT(std::sqrt(covariance(3, 3)), 5.1 * 9e9) << "5 m/s all the time";
}

TEST_F(SegmentsTest, BlindFlightEndsWhereThePlaceIsUnknown) {
  segments_.Begin(x_);
  Matrix<15, 15> covariance = Small();
  covariance.diagonal().segment<3>(3).setConstant(1);  // far from the beginning, but seen
  segments_.Keep(x_, covariance, true);
  EXPECT_FALSE(segments_.HasDriftedAway(x_, covariance));
  covariance.diagonal().segment<3>(3).setConstant(2);
  EXPECT_TRUE(segments_.HasDriftedAway(x_, covariance));
  segments_.Keep(x_, covariance, false);
  EXPECT_TRUE(segments_.HasDriftedAway(x_, covariance)) << "nobody has seen where it is";
  segments_.Keep(x_, covariance, true);
  EXPECT_FALSE(segments_.HasDriftedAway(x_, covariance));
}

}  // namespace
}  // namespace facet
