// SPDX-License-Identifier: BSD-2-Clause
// Mounts that are measured axis by axis, or only together with something else.
#include "facet/calibration/rough_mount.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/angles.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

constexpr double kCarefulTurn = 0.06 * kDegree, kCarefulShift_m = 0.002;
constexpr double kTurnNoise = 0.04 * kDegree, kShiftNoise_m = 0.004, kClockNoise_s = 1e-4;

class MountMeasurements {
 public:
  explicit MountMeasurements(std::uint64_t seed) : rng_(seed) {
    CalibrationVector sigma = CalibrationVector::Constant(1e-7);
    sigma.segment<2>(kPrincipalPoint).setConstant(0.5);
    sigma.segment<2>(kNumIntrinsics + kPrincipalPoint).setConstant(0.5);
    sigma.segment<3>(kMountRotation).setConstant(kCarefulTurn);
    sigma.segment<3>(kMountTranslation).setConstant(kCarefulShift_m);
    sigma(kTimeOffset) = 0.001;
    sigma.segment<3>(kGyroScale).setConstant(0.005);
    before_ = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    information_ = before_;
    for (double& x : careful_)
      x = rng_.Normal();
    careful_ = careful_.cwiseProduct(sigma);
  }

  void Measure(const CalibrationVector& row, const CalibrationVector& error, double noise) {
    const double measured = row.dot(careful_ + error) + noise * rng_.Normal();
    information_ += row * row.transpose() / (noise * noise);
    gradient_ += row * (measured / (noise * noise));
  }

  // Everything that motion shows.
  void MeasureAll(const CalibrationVector& error) {
    for (int axis = 0; axis < 3; ++axis) {
      Measure(CalibrationVector::Unit(kMountRotation + axis), error, kTurnNoise);
      Measure(CalibrationVector::Unit(kMountTranslation + axis), error, kShiftNoise_m);
    }
    Measure(CalibrationVector::Unit(kTimeOffset), error, kClockNoise_s);
  }

  std::optional<FreedEstimate> Found() const {
    const CalibrationMatrix left = information_.inverse();
    return FindRoughMount(EurocRig(), before_, left * gradient_, left);
  }

 private:
  Rng rng_;
  CalibrationVector careful_;
  CalibrationMatrix before_, information_;
  CalibrationVector gradient_ = CalibrationVector::Zero();
};

TEST(FindRoughMountTest, HalfADegreeIsFoundWithItsSize) {
  for (int axis = 0; axis < 3; ++axis) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const double turn = (seed % 2 == 0 ? 0.5 : -0.5) * kDegree;
      MountMeasurements mount(seed);
      mount.MeasureAll(turn * CalibrationVector::Unit(kMountRotation + axis));
      const auto found = mount.Found();
      ASSERT_TRUE(found) << axis << " " << seed;
      EXPECT_NEAR(found->delta(kMountRotation + axis), turn, 4 * kTurnNoise) << seed;
      EXPECT_LT(std::sqrt(found->left(kMountRotation + axis, kMountRotation + axis)),
                1.01 * kTurnNoise);
    }
  }
}

TEST(FindRoughMountTest, AShiftByCentimetresIsFound) {
  MountMeasurements mount(1);
  mount.MeasureAll(0.03 * CalibrationVector::Unit(kMountTranslation + 1));
  const auto found = mount.Found();
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->delta(kMountTranslation + 1), 0.03, 4 * kShiftNoise_m);
}

TEST(FindRoughMountTest, ACarefulMountIsLeftInPeace) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    MountMeasurements mount(seed);
    mount.MeasureAll(CalibrationVector::Zero());
    EXPECT_FALSE(mount.Found()) << seed;
  }
}

TEST(FindRoughMountTest, AnotherErrorIsNotTakenForIt) {
  MountMeasurements clock(1);
  clock.MeasureAll(0.01 * CalibrationVector::Unit(kTimeOffset));
  EXPECT_FALSE(clock.Found());
  // Far points of images that were cropped otherwise move as if the cameras were turned on the IMU.
  const double focal_px = EurocRig().cameras[0].mean_focal_px();
  const CalibrationVector cropped = CalibrationVector::Unit(kPrincipalPoint) +
                                    CalibrationVector::Unit(kNumIntrinsics + kPrincipalPoint);
  MountMeasurements together(2);
  together.Measure(
      0.5 * cropped + focal_px * CalibrationVector::Unit(kMountRotation + 1), 5 * cropped, 0.1);
  EXPECT_FALSE(together.Found());
}

}  // namespace
}  // namespace facet
