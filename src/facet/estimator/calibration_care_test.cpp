// SPDX-License-Identifier: BSD-2-Clause
// A calibration that measurements tell to a tenth of its first sigmas, in all directions.
#include "facet/estimator/calibration_care.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/estimator/solver/calibration_walk.h"
#include "facet/estimator/start/start_calibration.h"
#include "facet/estimator/window/calibration_information.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

constexpr int kPose = 6;
constexpr double kMeasuredShare = 0.01;  // of the first covariance, that measurements alone leave

class CalibrationCareTest : public ::testing::Test {
 protected:
  explicit CalibrationCareTest(const CalibrationOptions& options = {})
      : first_(StartCovariance(EurocRig(), options)),
        care_(first_, options),
        possible_(first_),
        first_information_(InformationOf(first_)) {
    prior_.blocks = {MarginalPrior::Block::OfPose(FrameId{1}, 0),
                     MarginalPrior::Block::OfCalibration(kPose)};
    prior_.H = MatrixXd::Identity(kPose + kNumCalibration, kPose + kNumCalibration);
    prior_.b = VectorXd::Zero(kPose + kNumCalibration);
    prior_.H.bottomRightCorner<kNumCalibration, kNumCalibration>() =
        (1 + 1 / kMeasuredShare) * first_information_;
  }

  /// As wrong as the first covariance says.
  CalibrationVector Draw() {
    const CalibrationVector sigma = first_.diagonal().cwiseSqrt();
    const CalibrationMatrix correlation =
        sigma.cwiseInverse().asDiagonal() * first_ * sigma.cwiseInverse().asDiagonal();
    CalibrationVector normal;
    for (double& n : normal)
      n = rng_.Normal();
    return sigma.cwiseProduct(CalibrationVector(correlation.llt().matrixL() * normal));
  }

  CalibrationMatrix Covariance() const {
    return InformationOf(prior_.H.bottomRightCorner<kNumCalibration, kNumCalibration>());
  }

  /// The measurements say that the calibration is off by this.
  void JudgeBy(const CalibrationVector& measured) {
    prior_.b.tail<kNumCalibration>() = -(first_information_ * measured) / kMeasuredShare;
    const CalibrationMatrix covariance = Covariance();
    care_.Judge(-covariance * prior_.b.tail<kNumCalibration>(), covariance, prior_, possible_);
  }

  void TakeStep(double share) {
    ASSERT_TRUE(TakeRandomStep(share * first_, prior_));
    care_.AddStep(share);
    possible_ += share * first_;
  }

  /// Variance of a parameter before any measurement, over the first one.
  double ShareOf(int parameter) const {
    return possible_(parameter, parameter) / first_(parameter, parameter);
  }

  Rng rng_{3};
  CalibrationMatrix first_;
  CalibrationCare care_;
  MarginalPrior prior_;
  CalibrationMatrix possible_;
  CalibrationMatrix first_information_;
};

class HeldLensesCareTest : public CalibrationCareTest {
 protected:
  HeldLensesCareTest() : CalibrationCareTest({.lens = false}) {}
};

TEST_F(CalibrationCareTest, AnExactCalibrationIsBelieved) {
  JudgeBy(CalibrationVector::Zero());
  EXPECT_LT(ShareOf(0), 0.02);
  EXPECT_LT(ShareOf(kLensModes), 0.02);
  EXPECT_LT(ShareOf(kMountTranslation), 0.5) << "of six parameters little can be said";
  EXPECT_EQ(ShareOf(kTimeOffset), 1);
  EXPECT_EQ(ShareOf(kGyroScale), 1);
  // It is as if the prior had been that tight from the beginning.
  const double share = ShareOf(kLensModes);
  const double expected = first_(kLensModes, kLensModes) / (1 / share + 1 / kMeasuredShare);
  EXPECT_NEAR(Covariance()(kLensModes, kLensModes), expected, 1e-9 * expected);
  EXPECT_EQ(prior_.H.topLeftCorner(kPose, kPose), MatrixXd(MatrixXd::Identity(kPose, kPose)));
}

TEST_F(CalibrationCareTest, WhatIsAsWrongAsItMayBeKeepsItsRoomAndTheRestIsBelieved) {
  CalibrationVector measured = Draw();
  LensModesOf(measured, 0).setZero();
  LensModesOf(measured, 1).setZero();
  JudgeBy(measured);
  EXPECT_LT(ShareOf(kLensModes), 0.02);
  EXPECT_GT(ShareOf(0), 0.95);
  EXPECT_GT(ShareOf(kMountRotation), 0.8);
}

TEST_F(CalibrationCareTest, WhereLensesDoMuchBesideTheirModelsTheirParametersKeepTheirRoom) {
  CalibrationVector measured = CalibrationVector::Zero();
  LensModesOf(measured, 0).setConstant(std::sqrt(first_(kLensModes, kLensModes)));
  LensModesOf(measured, 1).setConstant(-std::sqrt(first_(kLensModes, kLensModes)));
  JudgeBy(measured);
  EXPECT_GT(ShareOf(kLensModes), 0.95);
  EXPECT_GT(ShareOf(0), 0.95);
}

TEST_F(CalibrationCareTest, WhatTurnsOutToBeWrongLaterHasItsRoomAgainAndWhatWasMeasuredStays) {
  const CalibrationMatrix before = Covariance();
  JudgeBy(CalibrationVector::Zero());
  ASSERT_LT(ShareOf(0), 0.02);
  const CalibrationVector drawn = Draw();
  for (int look = 0; look < 5; ++look)
    JudgeBy(drawn);
  EXPECT_GT(ShareOf(0), 0.9);
  EXPECT_GT(ShareOf(kLensModes), 0.9);
  EXPECT_NEAR(Covariance()(0, 0), before(0, 0), 1e-3 * before(0, 0));
}

TEST_F(CalibrationCareTest, WhatRandomStepsHaveAddedStays) {
  JudgeBy(CalibrationVector::Zero());
  const double before = ShareOf(kLensModes);
  constexpr double kStep = 0.001;
  TakeStep(kStep);
  const CalibrationMatrix stepped = Covariance();
  care_.Judge(CalibrationVector::Zero(), stepped, prior_, possible_);
  EXPECT_NEAR(ShareOf(kLensModes), before + kStep, 0.1 * (before + kStep));
  EXPECT_GT(Covariance()(kLensModes, kLensModes), 0.9 * stepped(kLensModes, kLensModes));
}

TEST_F(CalibrationCareTest, ModesSettleWhenTheyHaveBeenSmallForSomeLooks) {
  for (int look = 0; look < 4; ++look) {
    JudgeBy(CalibrationVector::Zero());
    EXPECT_FALSE(care_.AreModesSettled());
  }
  JudgeBy(Draw());
  JudgeBy(CalibrationVector::Zero());
  EXPECT_FALSE(care_.AreModesSettled()) << "these four do not count any more";
  for (int look = 0; look < 4; ++look)
    JudgeBy(CalibrationVector::Zero());
  EXPECT_TRUE(care_.AreModesSettled());
}

TEST_F(CalibrationCareTest, SettledModesKeepTheirShareUntilRandomStepsHaveAddedUp) {
  for (int look = 0; look < 5; ++look)
    JudgeBy(CalibrationVector::Zero());
  ASSERT_TRUE(care_.AreModesSettled());
  const double share = ShareOf(kLensModes);
  JudgeBy(Draw());
  EXPECT_EQ(ShareOf(kLensModes), share) << "nothing measures them";
  EXPECT_GT(ShareOf(0), 0.9);
  int num_steps = 0;
  for (; care_.AreModesSettled() && num_steps < 1000; ++num_steps)
    TakeStep(0.001);
  EXPECT_NEAR(num_steps, 50, 1);
  const CalibrationVector drawn = Draw();
  for (int look = 0; look < 5; ++look)
    JudgeBy(drawn);
  EXPECT_GT(ShareOf(kLensModes), 0.9);
}

TEST_F(CalibrationCareTest, GivenUpAllIsAsItWas) {
  const MatrixXd before = prior_.H;
  JudgeBy(CalibrationVector::Zero());
  ASSERT_LT(ShareOf(0), 0.02);
  care_.GiveUp(prior_, possible_);
  EXPECT_LT((prior_.H - before).norm(), 1e-9 * before.norm());
  for (const int parameter : {0, static_cast<int>(kLensModes), static_cast<int>(kMountRotation)})
    EXPECT_NEAR(ShareOf(parameter), 1, 1e-9) << parameter;
}

TEST_F(CalibrationCareTest, APriorThatDoesNotKnowTheCalibrationStays) {
  MarginalPrior of_a_pose;
  of_a_pose.blocks = {MarginalPrior::Block::OfPose(FrameId{1}, 0)};
  of_a_pose.H = MatrixXd::Identity(kPose, kPose);
  of_a_pose.b = VectorXd::Ones(kPose);
  care_.Judge(CalibrationVector::Zero(), Covariance(), of_a_pose, possible_);
  EXPECT_EQ(of_a_pose.H, MatrixXd(MatrixXd::Identity(kPose, kPose)));
  EXPECT_EQ(possible_, first_);
}

TEST_F(HeldLensesCareTest, WhatIsHeldIsLeftAlone) {
  JudgeBy(CalibrationVector::Zero());
  EXPECT_EQ(ShareOf(0), 1);
  EXPECT_EQ(ShareOf(kLensModes), 1);
  EXPECT_LT(ShareOf(kMountTranslation), 0.5);
}

}  // namespace
}  // namespace facet
