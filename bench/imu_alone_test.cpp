// SPDX-License-Identifier: BSD-2-Clause
// The IMU alone against the ground truth of two real flights, over 0.2 s.
#include "imu_alone_study.h"
#include <gtest/gtest.h>

#include "facet/testing/data_dir.h"

namespace facet {
namespace {

constexpr Duration kLength{200'000'000};

class ImuAloneTest : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::string name = std::string("euroc_flights/") + GetParam();
    const auto folder = testing::DataDir(name);
    if (!folder) GTEST_SKIP() << testing::MissingData(name);
    flight_ = LoadFlight(*folder);
  }

  Flight flight_;
};

INSTANTIATE_TEST_SUITE_P(Euroc, ImuAloneTest, ::testing::Values("V1_02_medium", "MH_05_difficult"));

double RmsPerAxis(double norm_rms) {
  return norm_rms / std::sqrt(3.0);
}

TEST_P(ImuAloneTest, PredictsTheTruthOver200Ms) {
  const auto intervals = PredictFlight(flight_, kLength);
  ASSERT_GT(intervals.size(), 400u);
  const ErrorStatistics s = Summarise(intervals);
  EXPECT_LT(RmsPerAxis(s.norm_rms(0)), 3.5e-4) << "rad";
  EXPECT_LT(RmsPerAxis(s.norm_rms(1)), 3e-3) << "m";
  EXPECT_LT(RmsPerAxis(s.norm_rms(2)), 1.1e-2) << "m/s";
}

void ExpectNoMean(const NineErrors& errors) {
  for (int i = 0; i < 9; ++i) {
    EXPECT_LT(std::abs(errors.mean(i)), 3 * errors.standard_error(i)) << "component " << i;
  }
}

// A wrong sign or frame anywhere shows as a mean error.
TEST_P(ImuAloneTest, HasNoMeanErrorInTheBody) {
  ExpectNoMean(Summarise(PredictFlight(flight_, kLength)).B);
}

// The z axis of the ground truth is not exactly vertical (V1_02: 2.0 mrad), which is a mean
// velocity error in its frame. Without that tilt neither half of the flight has any.
TEST_P(ImuAloneTest, HasNoMeanErrorInAFrameAlignedWithGravity) {
  const Vector3d g_W = GravityWithoutMeanError(PredictFlight(flight_, kLength));
  EXPECT_NEAR(g_W.norm(), kGravity, 5e-3);
  EXPECT_LT(std::hypot(g_W.x(), g_W.y()) / g_W.norm(), 2.5e-3) << "rad";
  const auto all = PredictFlight(flight_, kLength, {g_W.x(), g_W.y(), -kGravity});
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  ExpectNoMean(Summarise({all.begin(), middle}).W);
  ExpectNoMean(Summarise({middle, all.end()}).W);
}

}  // namespace
}  // namespace facet
