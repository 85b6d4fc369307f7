// SPDX-License-Identifier: BSD-2-Clause
#include "live_state_study.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

// Between the frames the state is as exact and as honest as at the frames, in all of its parts, and
// a call is cheap (four times that are allowed where tests run side by side).
TEST(LiveStateStudyTest, IsAsGoodAsTheFramesStates) {
  LiveStateOptions options;
  options.consistency.num_seeds = 3;
  for (const Scenario& scenario : MadeUpScenarios(12)) {
    const LiveStateFigures figures = StudyLiveState(scenario, options);
    SCOPED_TRACE(figures.name);
    EXPECT_GT(figures.predictions.nees.count, 3 * 200 * 10);
    EXPECT_LT(figures.RmseRatio(), 1.1);
    EXPECT_LT(figures.NeesDeviation(StatePart::kPosition), 0.1);
    EXPECT_LT(figures.NeesDeviation(StatePart::kPose), 0.1);
    EXPECT_LT(figures.NeesDeviation(StatePart::kAll), 0.1);
    EXPECT_LT(figures.largest_step_m, 0.2 * figures.largest_jump_m);
    EXPECT_LT(figures.predict.Mean(), 80);
  }
}

}  // namespace
}  // namespace facet
