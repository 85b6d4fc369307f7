// SPDX-License-Identifier: BSD-2-Clause
// How fast the calibration is forgotten: the random steps of SelfCalibration, against what
// docs/math.md (section 10) says of them, and their limits.
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/calibration/drawn_calibration.h"
#include "facet/estimator/self_calibration.h"
#include "facet/estimator/start/start_calibration.h"
#include "facet/estimator/vio_estimator.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/estimator/spoilt_run.h"
#include "facet/testing/wrong_rigs.h"

namespace facet {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// A run that has learnt the calibration to a tenth of its first uncertainty, and learns no more.
class WalkTest : public ::testing::Test {
 protected:
  explicit WalkTest(const CalibrationOptions& options = {})
      : rig_(EurocRig()), start_(StartCovariance(rig_, options)), calibration_(rig_, options) {
    calibration_.Begin(window_);
    window_.prior.blocks = {MarginalPrior::Block::OfCalibration(0)};
    window_.prior.H = (0.01 * start_).inverse();
    window_.prior.b = VectorXd::Zero(kNumCalibration);
    window_.frames.emplace_back();
  }

  // A keyframe at this time.
  void WalkAt(double seconds) {
    window_.frames.back().x.t = Timestamp{1'400'000'000'000'000'000} + FromSeconds(seconds);
    calibration_.Walk(window_);
  }

  MatrixXd Covariance() const { return window_.prior.H.inverse(); }

  // The largest difference, in units of the first uncertainty.
  double OffFrom(const MatrixXd& expected) const {
    const VectorXd sigma = start_.diagonal().cwiseSqrt();
    return (Covariance() - expected).cwiseQuotient(sigma * sigma.transpose()).cwiseAbs().maxCoeff();
  }

  // Variance along the line between the cameras.
  double BaselineVariance() const {
    const Vector3d along = rig_.T_C1C0().p.normalized();
    return along.dot(Covariance().block<3, 3>(kStereoTranslation, kStereoTranslation) * along);
  }

  StereoRig rig_;
  CalibrationMatrix start_;
  SelfCalibration calibration_;
  SlidingWindow window_;
};

class HeldLensesTest : public WalkTest {
 protected:
  HeldLensesTest() : WalkTest({.lens = false}) {}
};

TEST_F(WalkTest, NothingIsForgottenWithinTenSeconds) {
  for (double t_s = 0; t_s < 9.9; t_s += 0.2)
    WalkAt(t_s);
  EXPECT_LT(OffFrom(0.01 * start_), 1e-6);
}

TEST_F(WalkTest, EveryTenSecondsThreePercentOfTheFirstUncertaintyAreAdded) {
  WalkAt(0);
  for (int step = 1; step <= 3; ++step) {
    WalkAt(10.0 * step);
    EXPECT_LT(OffFrom((0.01 + step * 0.03 * 0.03) * start_), 1e-6) << step;
  }
}

// However often keyframes come.
TEST_F(WalkTest, AfterAnHourHalfOfTheFirstUncertaintyHasAddedUp) {
  for (double t_s = 0; t_s <= 3600; t_s += 0.5)
    WalkAt(t_s);
  for (int i = 0; i < kNumCalibration; ++i) {
    const double share = std::sqrt(Covariance()(i, i) / start_(i, i) - 0.01);
    EXPECT_GT(share, 0.45) << kCalibrationNames[static_cast<std::size_t>(i)];
    EXPECT_LT(share, 0.6) << kCalibrationNames[static_cast<std::size_t>(i)];
  }
}

TEST_F(WalkTest, ADoubtedBaselineIsFreedByThatShareOfItOnce) {
  WalkAt(0);
  const double before = BaselineVariance();
  constexpr double kShare = 0.07;
  calibration_.DoubtBaseline(kShare);
  EXPECT_EQ(BaselineVariance(), before) << "it counts with the next step";
  WalkAt(1);
  const double freed_m = kShare * rig_.baseline_m();
  EXPECT_NEAR(BaselineVariance() - before, freed_m * freed_m, 1e-6 * freed_m * freed_m);
  // Nothing but the distance: directions across it, lenses, mount and clock are as they were.
  MatrixXd expected = 0.01 * start_;
  const Vector3d change = kShare * rig_.T_C1C0().p;
  expected.block<3, 3>(kStereoTranslation, kStereoTranslation) += change * change.transpose();
  EXPECT_LT(OffFrom(expected), 1e-4);
  WalkAt(2);
  EXPECT_NEAR(BaselineVariance() - before, freed_m * freed_m, 1e-6 * freed_m * freed_m) << "once";
}

TEST_F(WalkTest, ADoubtThatIsTooSmallAndOneThatIsTooLargeAreTheSame) {
  WalkAt(0);
  const double before = BaselineVariance();
  calibration_.DoubtBaseline(-0.07);
  WalkAt(1);
  const double freed_m = 0.07 * rig_.baseline_m();
  EXPECT_NEAR(BaselineVariance() - before, freed_m * freed_m, 1e-6 * freed_m * freed_m);
}

TEST_F(HeldLensesTest, ADoubtedBaselineStays) {
  WalkAt(0);
  const MatrixXd before = Covariance();
  calibration_.DoubtBaseline(0.07);
  WalkAt(1);
  EXPECT_EQ(Covariance(), before);
}

// Estimates of calibrations that are as wrong as was believed; a half of the directions is learnt,
// of the others nothing.
TEST(CalibrationSurpriseTest, IsOneForWhatWasBelievedAndTheSquareOfAFactor) {
  const CalibrationMatrix possible = StartCovariance(EurocRig(), {});
  const CalibrationMatrix root = possible.llt().matrixL();
  constexpr int kNumLearnt = kNumCalibration / 2;
  CalibrationMatrix unknown = CalibrationMatrix::Identity();
  unknown.diagonal().head<kNumLearnt>().setConstant(0.05);
  const CalibrationMatrix left = root * unknown * root.transpose();
  Rng rng(1);
  constexpr int kRuns = 400;
  double sum = 0, sum_of_wrong = 0;
  for (int run = 0; run < kRuns; ++run) {
    CalibrationVector learnt = CalibrationVector::Zero();
    for (int k = 0; k < kNumLearnt; ++k)
      learnt(k) = std::sqrt(0.95) * rng.Normal();
    const CalibrationVector delta = root * learnt;
    sum += CalibrationSurprise(delta, possible, left) / kRuns;
    sum_of_wrong += CalibrationSurprise(3 * delta, possible, left) / kRuns;
  }
  EXPECT_NEAR(sum, 1, 0.05);
  const double num_learnt = 0.95 * kNumLearnt;
  EXPECT_NEAR(sum_of_wrong, (9 * num_learnt + 3) / (num_learnt + 3), 0.3);
  EXPECT_LT(CalibrationSurprise(CalibrationVector::Zero(), possible, possible), 1.01)
      << "nothing learnt is no surprise";
}

// Against the sum of the information, for a calibration that was as uncertain as a careful one, and
// measurements of which some see most parameters together.
TEST(LeftWithNoiseTest, IsWhatMeasurementsWithThatNoiseWouldLeave) {
  const CalibrationMatrix possible = StartCovariance(EurocRig(), {});
  const CalibrationVector inverse = possible.diagonal().cwiseSqrt().cwiseInverse();
  Rng rng(2);
  CalibrationMatrix learnt = CalibrationMatrix::Zero();
  for (int i = 0; i < 20; ++i) {
    CalibrationVector row;
    for (double& x : row)
      x = (i < 10 ? 1 : 30) * rng.Normal();
    row = row.cwiseProduct(inverse);
    learnt += row * row.transpose();
  }
  const auto left_with = [&](double factor) {
    const CalibrationMatrix scaled_back = inverse.cwiseInverse().asDiagonal() * (learnt / factor) *
                                          inverse.cwiseInverse().asDiagonal();
    const CalibrationMatrix before = inverse.asDiagonal() * possible * inverse.asDiagonal();
    const CalibrationMatrix left = (before.inverse() + scaled_back).inverse();
    return left;
  };
  for (const double factor : {0.2, 1.0, 4.0}) {
    const CalibrationMatrix left =
        inverse.cwiseInverse().asDiagonal() * left_with(1) * inverse.cwiseInverse().asDiagonal();
    const CalibrationMatrix found =
        inverse.asDiagonal() * LeftWithNoise(factor, possible, left) * inverse.asDiagonal();
    EXPECT_LT((found - left_with(factor)).norm(), 1e-6 * left_with(factor).norm()) << factor;
  }
}

TEST(LeftWithNoiseTest, LeavesWhatIsHeldOrWasNotLearntAsItIs) {
  CalibrationOptions held;
  held.lens = false;
  for (const CalibrationOptions& options : {CalibrationOptions(), held}) {
    const CalibrationMatrix possible = StartCovariance(EurocRig(), options);
    const CalibrationVector inverse = possible.diagonal().cwiseSqrt().cwiseInverse();
    for (const double factor : {0.2, 5.0}) {
      const CalibrationMatrix change = inverse.asDiagonal() *
                                       (LeftWithNoise(factor, possible, possible) - possible) *
                                       inverse.asDiagonal();
      EXPECT_LT(change.cwiseAbs().maxCoeff(), 1e-6) << factor;
      const CalibrationMatrix more = LeftWithNoise(factor, possible, 4 * possible);
      EXPECT_LT((inverse.asDiagonal() * (more - 4 * possible) * inverse.asDiagonal()).norm(), 1e-6)
          << "more than before is no information";
    }
  }
  const CalibrationMatrix no_covariance = -CalibrationMatrix::Identity();
  EXPECT_EQ(LeftWithNoise(0.2, CalibrationMatrix::Zero(), no_covariance), no_covariance);
}

SimulatedRun FlyWith(double duration_s, std::uint64_t seed) {
  FeatureSimulatorOptions options;
  options.max_tracks = 70;
  options.duration_s = duration_s;
  return SimulateFeatures(
      SplineTrajectory::Fit(MakeFlight(duration_s, seed)), EurocRig(), options, seed);
}

// What an estimator makes of a calibration that was written.
struct FlightOutcome {
  double left_ratio = 0, right_ratio = 0;  ///< focal lengths over the true ones
  std::string gross, first_gross;          ///< as it is named, at the end and first
  StereoRig rig;
  std::vector<double> freed_at_s;  ///< since the first image
};

FlightOutcome Estimate(const SimulatedRun& run, const StereoRig& written) {
  VioEstimator estimator(written, ImuNoise{}, EstimatorOptions{});
  const ImuBuffer imu = testing::ImuOf(run);
  StageTimes times;
  FlightOutcome out;
  std::optional<Timestamp> freed_at;
  const Timestamp begin = run.frames.front().t + written.time_offset;
  Timestamp previous = begin;
  for (const FrameObservations& frame : run.frames) {
    const Timestamp now = frame.t + written.time_offset;
    estimator.AddFrame(frame, imu.Between(previous, now, Duration{20'000'000}, Duration{0}), times);
    previous = now;
    if (out.first_gross.empty()) out.first_gross = InWords(estimator.GrossDeviations());
    if (estimator.calibration_freed_at() == freed_at) continue;
    freed_at = estimator.calibration_freed_at();
    out.freed_at_s.push_back(ToSeconds(*freed_at - begin));
  }
  const StereoRig* kept = estimator.KeptRig();
  if (kept == nullptr) return out;
  const auto ratio = [&](std::size_t c) {
    return kept->cameras[c].mean_focal_px() / run.rig.cameras[c].mean_focal_px();
  };
  out.rig = *kept;
  out.left_ratio = ratio(0);
  out.right_ratio = ratio(1);
  out.gross = InWords(estimator.GrossDeviations());
  return out;
}

// A clock that is off by far more than one step allows is freed again and again.
TEST(LargeStepTest, APartIsFreedThreeTimesAtMostAndSettlesInBetween) {
  const SimulatedRun run = FlyWith(30, 2);
  StereoRig written = *DrawCalibration(run.rig, 1);
  written.time_offset = written.time_offset + Duration{60'000'000};
  const FlightOutcome out = Estimate(run, written);
  ASSERT_GE(out.freed_at_s.size(), 2u);
  EXPECT_LE(out.freed_at_s.size(), 6u) << "the mount may have to make room, too";
  for (std::size_t i = 1; i < out.freed_at_s.size(); ++i)
    EXPECT_GE(out.freed_at_s[i] - out.freed_at_s[i - 1], 4.999) << i;
  EXPECT_THAT(out.gross, HasSubstr("time offset"));
}

// The scale of the gyroscope is estimated, too, and could take up most of the error.
TEST(RoomForFocalLengthsTest, RoughOnesAreFoundInSecondsAndNamed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    for (const double ratio : {0.99, 1.01}) {
      const SimulatedRun run = FlyWith(14, seed);
      const FlightOutcome out =
          Estimate(run, testing::WithFocalLengths(*DrawCalibration(run.rig, seed), ratio));
      EXPECT_NEAR(out.left_ratio, 1, 0.003) << seed;
      EXPECT_NEAR(out.right_ratio, 1, 0.003) << seed;
      ASSERT_FALSE(out.freed_at_s.empty()) << seed;
      EXPECT_LT(out.freed_at_s[0], 8) << seed;
      EXPECT_THAT(out.gross, HasSubstr("focal length of the left camera")) << seed;
      EXPECT_THAT(out.gross, HasSubstr("focal length of the right camera")) << seed;
    }
  }
}

TEST(RoomForFocalLengthsTest, CarefulOnesNeedNone) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SimulatedRun run = FlyWith(14, seed);
    const FlightOutcome out = Estimate(run, *DrawCalibration(run.rig, seed));
    EXPECT_NEAR(out.left_ratio, 1, 0.002) << seed;
    EXPECT_EQ(out.gross, "") << seed;
    EXPECT_TRUE(out.freed_at_s.empty()) << seed;
  }
}

TEST(RoomForFocalLengthsTest, AGyroscopeWithAnotherScaleIsNotTakenForThem) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SimulatedRun run = FlyWith(14, seed);
    for (ImuSample& sample : run.imu)
      sample.gyro *= 1.02;
    const FlightOutcome out = Estimate(run, *DrawCalibration(run.rig, seed));
    EXPECT_NEAR(out.left_ratio, 1, 0.003) << seed;
    EXPECT_THAT(out.gross, Not(HasSubstr("focal length"))) << seed;
  }
}

// What the right camera sees of far points that the left one sees in the middle of its image.
double FarPointOff_px(const StereoRig& rig, const StereoRig& truth) {
  const auto far = [](const StereoRig& r) {
    return *r.cameras[1].Project(r.T_C1C0().q * *r.cameras[0].Unproject(Vector2d(376, 240)));
  };
  return (far(rig) - far(truth)).norm();
}

TEST(RoomForLensesTest, ATurnedRightCameraIsFoundInSecondsAndNamed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedRun run = FlyWith(12, seed);
    StereoRig written = *DrawCalibration(run.rig, seed);
    written.T_BC[1].q = written.T_BC[1].q * ExpSO3(Vector3d(0, 0.4 * kDegree, 0));
    const FlightOutcome out = Estimate(run, written);
    ASSERT_EQ(out.freed_at_s.size(), 1u) << seed;
    EXPECT_LT(out.freed_at_s[0], 4) << seed;
    EXPECT_LT(FarPointOff_px(out.rig, run.rig), 0.1) << seed;
    EXPECT_THAT(out.gross, HasSubstr("far points in the right image")) << seed;
  }
}

TEST(RoomForLensesTest, APrincipalPointIsFoundInSecondsAndNamed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedRun run = FlyWith(12, seed);
    StereoRig written = *DrawCalibration(run.rig, seed);
    CameraIntrinsics k = written.cameras[0].intrinsics();
    k.cx += 5;
    written.cameras[0] = CameraModel(k);
    const FlightOutcome out = Estimate(run, written);
    ASSERT_EQ(out.freed_at_s.size(), 1u) << seed;
    EXPECT_LT(FarPointOff_px(out.rig, run.rig), 0.1) << seed;
    EXPECT_NEAR(out.rig.cameras[0].intrinsics().cx, run.rig.cameras[0].intrinsics().cx, 1) << seed;
    EXPECT_THAT(out.gross, HasSubstr("principal point of the left camera in x")) << seed;
  }
}

TEST(RoomForLensesTest, AnotherDistortionIsFoundInSecondsAndNamed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedRun run = FlyWith(12, seed);
    StereoRig written = *DrawCalibration(run.rig, seed);
    for (CameraModel& camera : written.cameras) {
      CameraIntrinsics k = camera.intrinsics();
      k.coefficients[0] *= 1.05;
      camera = CameraModel(k);
    }
    const FlightOutcome out = Estimate(run, written);
    ASSERT_EQ(out.freed_at_s.size(), 1u) << seed;
    EXPECT_NEAR(out.left_ratio, 1, 0.003) << seed;
    EXPECT_THAT(out.gross, HasSubstr("distortion at the edge of the left camera")) << seed;
    EXPECT_THAT(out.gross, HasSubstr("distortion at the edge of the right camera")) << seed;
    EXPECT_THAT(out.gross, Not(HasSubstr("focal length"))) << seed;
  }
}

StereoRig WithTurnedMount(StereoRig rig, const Vector3d& turn_deg) {
  for (SE3& T_BC : rig.T_BC)
    T_BC = SE3(ExpSO3(kDegree * turn_deg), Vector3d::Zero()) * T_BC;
  return rig;
}

TEST(RoughMountTest, ATurnIsNamedBeforeItIsFreed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedRun run = FlyWith(25, seed);
    const FlightOutcome out =
        Estimate(run, WithTurnedMount(*DrawCalibration(run.rig, seed), {0, 0.5, 0}));
    EXPECT_THAT(out.first_gross, HasSubstr("cameras on the IMU about y (made good in part)"));
    EXPECT_THAT(out.gross, HasSubstr("cameras on the IMU about y")) << seed;
    EXPECT_THAT(out.gross, Not(HasSubstr("focal length"))) << seed;
  }
}

TEST(RoughMountTest, ACarefulOneIsNotNamed) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SimulatedRun run = FlyWith(25, seed);
    EXPECT_EQ(Estimate(run, *DrawCalibration(run.rig, seed)).gross, "") << seed;
  }
}

// There is nothing that both have in common in half of such an error.
TEST(RoomForFocalLengthsTest, OfOneCameraAloneTheyAreFoundAsWell) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedRun run = FlyWith(20, seed);
    StereoRig written = *DrawCalibration(run.rig, seed);
    written.cameras[0] = testing::WithFocalLengths(written, 1.01).cameras[0];
    const FlightOutcome out = Estimate(run, written);
    EXPECT_NEAR(out.left_ratio, 1, 0.003) << seed;
    EXPECT_NEAR(out.right_ratio, 1, 0.003) << seed;
    EXPECT_THAT(out.gross, HasSubstr("focal length of the left camera")) << seed;
  }
}

}  // namespace
}  // namespace facet
