// SPDX-License-Identifier: BSD-2-Clause
// The consistency study in small: made-up flights, a few seeds, wider bounds.
#include "consistency_study.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

constexpr double kDuration_s = 10;

ConsistencyOptions SmallStudy() {
  ConsistencyOptions options;
  options.num_seeds = 4;
  options.batch_seeds = 1;
  return options;
}

MeanRatios Sum(const std::vector<MeanRatios>& parts) {
  MeanRatios sum;
  for (const MeanRatios& part : parts) {
    for (std::size_t k = 0; k < kNumStateParts; ++k)
      sum.sum[k] += part.sum[k];
    sum.count += part.count;
  }
  return sum;
}

class ConsistencyTest : public ::testing::Test {
 protected:
  // One study for all tests of this file.
  static const std::vector<ConsistencyFigures>& Figures() {
    static const std::vector<ConsistencyFigures> figures = [] {
      std::vector<ConsistencyFigures> all;
      for (const Scenario& scenario : MadeUpScenarios(kDuration_s)) {
        all.push_back(StudyConsistency(scenario, SmallStudy()));
      }
      return all;
    }();
    return figures;
  }

  static MeanRatios OfKind(FrameKind kind) {
    std::vector<MeanRatios> parts;
    for (const ConsistencyFigures& f : Figures()) {
      for (const auto& bin : f.nees.by_time)
        parts.push_back(bin[static_cast<std::size_t>(kind)]);
    }
    return Sum(parts);
  }
};

TEST_F(ConsistencyTest, CovarianceDescribesTheErrorOfKeyframes) {
  const MeanRatios nees = OfKind(FrameKind::kKeyframe);
  EXPECT_GT(nees[StatePart::kPose], 0.7);
  EXPECT_LT(nees[StatePart::kPose], 1.4);
  EXPECT_LT(nees[StatePart::kVelocity], 1.5);
  EXPECT_LT(nees[StatePart::kAccelBias], 1.5);
}

TEST_F(ConsistencyTest, CovarianceDescribesTheErrorOfFramesInBetween) {
  const MeanRatios nees = OfKind(FrameKind::kPassing);
  EXPECT_GT(nees[StatePart::kPose], 0.7);
  EXPECT_LT(nees[StatePart::kPose], 1.4);
  EXPECT_LT(nees[StatePart::kVelocity], 1.5);
  EXPECT_LT(nees[StatePart::kAccelBias], 1.5);
}

TEST_F(ConsistencyTest, FixedLagIsNearlyAsGoodAsBatch) {
  double fixed_lag = 0, batch = 0;
  for (const ConsistencyFigures& f : Figures()) {
    EXPECT_EQ(f.num_resets, 0) << f.name;
    ASSERT_GT(f.ate.batch_count, 0) << f.name;
    fixed_lag += f.ate.final_where_batch;
    batch += f.ate.batch;
  }
  EXPECT_LT(fixed_lag, 1.3 * batch);
}

}  // namespace
}  // namespace facet
