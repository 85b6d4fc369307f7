// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/image_motion.h"

#include <cmath>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

// Turns and accelerates ever faster about and along fixed axes of the body.
constexpr double kAlpha = 8, kJerk = 40;  // rad/s^2, m/s^3
const Vector3d kAxis = Vector3d(1, -2, 2) / 3;

Vector3d GyroAt(double t) {
  return (0.5 + kAlpha * t) * kAxis;
}

// The body's turn in the 50 ms is small, so that gravity is as good as constant in B.
Vector3d AccelAt(double t, const Matrix3d& R_BW) {
  return Vector3d(2 + kJerk * t, 0, 0) - R_BW * GravityInWorld();
}

struct Interval {
  ImuLink link;
  NavState end;
};

Interval MakeInterval(double step_s) {
  Interval interval;
  const ImuBias bias{Vector3d(0.01, -0.02, 0.03), Vector3d(0.1, 0.2, -0.1)};
  interval.end.bias = bias;
  interval.end.T_WB.q = ExpSO3(Vector3d(0.3, -0.2, 0.1));
  const Matrix3d R_BW = interval.end.T_WB.R().transpose();
  std::vector<ImuSample> samples;
  for (double t = -0.05; t < 1e-6; t += step_s) {
    samples.push_back(
        {Timestamp{} + FromSeconds(1 + t), GyroAt(t) + bias.b_g, AccelAt(t, R_BW) + bias.b_a});
  }
  interval.link.measured = ImuPreintegration(bias, {});
  interval.link.measured.Integrate(samples);
  return interval;
}

TEST(ImageMotionTest, FollowsRatesThatChange) {
  const Interval interval = MakeInterval(0.005);
  for (const double offset : {-0.04, -0.01, 0.01, 0.03}) {
    const ImageMotion motion = MotionToImage(interval.link, interval.end, offset);
    const Vector3d turn = (0.5 * offset + 0.5 * kAlpha * offset * offset) * kAxis;
    EXPECT_LT((offset * motion.w_B - turn).norm(), 1e-9) << offset;
    const Vector3d moved(offset * offset + kJerk * offset * offset * offset / 6, 0, 0);
    EXPECT_LT((offset * motion.dv_B - moved).norm(), 1e-9) << offset;
  }
}

TEST(ImageMotionTest, TakesTheRatesAtTheStampForSmallOffsets) {
  const Interval interval = MakeInterval(0.005);
  const ImageMotion motion = MotionToImage(interval.link, interval.end, 0.001);
  EXPECT_LT((motion.w_B - GyroAt(0)).norm(), 1e-9);
  EXPECT_EQ(motion.dv_B, Vector3d::Zero());
}

TEST(ImageMotionTest, WithTooFewSamplesTheRatesAreConstant) {
  const Interval interval = MakeInterval(0.025);
  const ImageMotion motion = MotionToImage(interval.link, interval.end, -0.01);
  EXPECT_LT((motion.w_B - GyroAt(0)).norm(), 1e-9);
  EXPECT_NEAR(motion.dv_B.x(), -0.005 * 2, 1e-9);
}

TEST(ImageMotionTest, KnowsNothingWithoutSamples) {
  const ImageMotion motion = MotionToImage(ImuLink{}, NavState{}, 0.01);
  EXPECT_EQ(motion.w_B, Vector3d::Zero());
  EXPECT_EQ(motion.dv_B, Vector3d::Zero());
}

}  // namespace
}  // namespace facet
