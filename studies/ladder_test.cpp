// SPDX-License-Identifier: BSD-2-Clause
// The rungs of the ladder do what their names say.
#include <filesystem>
#include <fstream>

#include "ladder_report.h"
#include "scaled_run.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace facet {
namespace {

class LadderTest : public ::testing::Test {
 protected:
  static constexpr double kDuration_s = 34;

  // Once around the corridor with panels 10 cm before the walls, and a bit farther.
  static void SetUpTestSuite() {
    run_ = std::make_unique<SimulatedRun>(
        Simulate(CorridorScenarios(kDuration_s).back(), ConsistencyOptions(), 1));
    s_ = std::make_unique<Outcome>(Run("S"));
  }
  static void TearDownTestSuite() {
    run_.reset();
    s_.reset();
  }

  static Outcome Run(const std::string& key) {
    return RunRung(*run_, ConsistencyOptions(), SelectRungs(MakeRungs({}), {key}).back());
  }

  static std::unique_ptr<SimulatedRun> run_;
  static std::unique_ptr<Outcome> s_;
};
std::unique_ptr<SimulatedRun> LadderTest::run_;
std::unique_ptr<Outcome> LadderTest::s_;

TEST_F(LadderTest, PlanesWithTheMembersOfOthersAreRefused) {
  EXPECT_NEAR(Run("placebo").ate_m / s_->ate_m, 1, 0.03);
}

TEST_F(LadderTest, TruePlanesFindTheirOwnMembers) {
  const Outcome out = Run("own-association");
  EXPECT_GE(out.quality.num_created, 8);
  EXPECT_GE(out.quality.num_joined, 500);
  EXPECT_LT(out.quality.num_wrong, 0.1 * out.quality.num_joined);
  EXPECT_LT(out.ate_m, s_->ate_m);
}

TEST_F(LadderTest, AWrongReturnHappensOnceAndIsRecovered) {
  const Outcome right = Run("SPR"), wrong = Run("wrong-return");
  EXPECT_EQ(right.quality.num_events, 0);
  EXPECT_EQ(wrong.quality.num_events, 1);
  EXPECT_NE(wrong.ate_m, right.ate_m);
  EXPECT_LT(wrong.ate_m, 1.5 * right.ate_m);
}

TEST_F(LadderTest, AWorldOfAnotherSizeHasTheSameImages) {
  constexpr double kScale = 0.1;
  const SimulatedRun small = ScaledRun(*run_, kScale);
  EXPECT_EQ(small.frames[9].features[3].px_left, run_->frames[9].features[3].px_left);
  EXPECT_NEAR(small.rig.baseline_m(), kScale * run_->rig.baseline_m(), 1e-9);
  EXPECT_NEAR(small.truth[9].T_WB.p.norm(), kScale * run_->truth[9].T_WB.p.norm(), 1e-9);
  for (const std::size_t i : {10u, 1000u}) {
    EXPECT_NEAR((small.imu[i].accel - kScale * run_->imu[i].accel).norm(), 0, 1e-12);
    EXPECT_EQ(small.imu[i].gyro, run_->imu[i].gyro);
  }
}

TEST(LadderRungsTest, SIsAlwaysThereAndUnknownKeysAreNamed) {
  const auto rungs = SelectRungs(MakeRungs({}), {"SPR"});
  ASSERT_EQ(rungs.size(), 2u);
  EXPECT_EQ(rungs[0].key, "S");
  EXPECT_EQ(rungs[1].key, "SPR");
  try {
    SelectRungs(MakeRungs({}), {"spr"});
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("oracle-6s"));
  }
}

TEST(OutcomeFileTest, GoesOnWhereItStoppedAndRefusesOtherSettings) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("facet_outcomes_" + std::to_string(::getpid()) + ".csv");
  Outcome outcome;
  outcome.ate_m = 0.0125;
  outcome.quality.num_events = 1;
  OutcomeFile(path, "duration 5").Add("corridor", 3, "SPR", outcome);
  {
    const OutcomeFile again(path, "duration 5");
    const Outcome* known = again.Find("corridor", 3, "SPR");
    ASSERT_NE(known, nullptr);
    EXPECT_EQ(known->ate_m, 0.0125);
    EXPECT_EQ(known->quality.num_events, 1);
    EXPECT_EQ(again.Find("corridor", 4, "SPR"), nullptr);
    EXPECT_EQ(again.Find("corridor", 3, "S"), nullptr);
  }
  std::ofstream(path, std::ios::app) << "corridor,4,SPR,0.01";  // cut off in the middle of a line
  EXPECT_EQ(OutcomeFile(path, "duration 5").Find("corridor", 4, "SPR"), nullptr);
  EXPECT_THROW(OutcomeFile(path, "duration 6"), std::runtime_error);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace facet
