// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/calibration_writer.h"

#include <fstream>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/calibration/calibration_vector.h"
#include "facet/io/calibration_file.h"
#include "facet/io/errors.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

StereoRig RigWithCovariance() {
  StereoRig rig = EurocRig();
  rig.time_offset = Duration{-1'234'567};
  rig.gyro_scale = Vector3d(0.003, -0.001, 0.002);
  for (int k = 0; k < kNumLensModes; ++k) {
    rig.lens_modes[0](k) = 0.01 * k;
    rig.lens_modes[1](k) = 0.05 - 0.02 * k;
  }
  MatrixXd A = MatrixXd::Identity(kNumCalibration, kNumCalibration);
  A.diagonal(-1).setConstant(0.3);
  rig.covariance = std::make_shared<const MatrixXd>(1e-6 * A * A.transpose());
  return rig;
}

class CalibrationWriterTest : public ::testing::Test {
 protected:
  StereoRig ReadBack(const std::string& text) {
    const auto file = folder_.path() / "calibration.yaml";
    std::ofstream(file) << text;
    return ReadKalibrCalibration(file, {}).rig;
  }
  std::string ErrorOf(const std::string& text) {
    try {
      ReadBack(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }
  static std::string Replaced(std::string text, const std::string& a, const std::string& b) {
    const auto at = text.find(a);
    EXPECT_NE(at, std::string::npos);
    return text.replace(at, a.size(), b);
  }

  TempFolder folder_;
};

TEST_F(CalibrationWriterTest, IsReadBack) {
  const StereoRig rig = RigWithCovariance(), read = ReadBack(CalibrationYaml(rig));
  EXPECT_LT(CalibrationDifference(rig, read).norm(), 1e-8);
  EXPECT_EQ(read.time_offset, rig.time_offset);
  ASSERT_TRUE(read.covariance);
  EXPECT_LT((*read.covariance - *rig.covariance).norm(), 1e-10 * rig.covariance->norm());
}

TEST_F(CalibrationWriterTest, AScaleThatIsNoneIsRefused) {
  const std::string good = CalibrationYaml(RigWithCovariance());
  EXPECT_THAT(ErrorOf(Replaced(good, "[0.003, -0.001", "[0.003")), HasSubstr("three numbers"));
  EXPECT_THAT(ErrorOf(Replaced(good, "[0.003, ", "[1.003, ")), HasSubstr("too much"));
  EXPECT_TRUE(ReadBack(CalibrationYaml(EurocRig())).gyro_scale.isZero(0));
}

TEST_F(CalibrationWriterTest, ModesOfALensThatAreNoneAreRefused) {
  const std::string good = CalibrationYaml(RigWithCovariance());
  EXPECT_THAT(ErrorOf(Replaced(good, "[0, 0.01, ", "[0, ")), HasSubstr("10 modes, here are 9"));
  EXPECT_THAT(ErrorOf(Replaced(good, "[0, 0.01, ", "[0, 31, ")), HasSubstr("in pixels"));
  EXPECT_TRUE(ReadBack(CalibrationYaml(EurocRig())).lens_modes[0].isZero(0));
}

// Of a version that did not estimate them.
TEST_F(CalibrationWriterTest, ACovarianceWithoutModesSaysNothingOfThem) {
  std::string names, rows;
  for (int k = 0; k < kNumCalibration; ++k) {
    if (k >= kLensModes && k < kNumLensColumns) continue;
    names += (k == 0 ? "" : ", ") + std::string(kCalibrationNames[static_cast<std::size_t>(k)]);
    rows += "  - [";
    for (int j = 0; j < kNumCalibration - 2 * kNumLensModes; ++j)
      rows += std::string(j == 0 ? "" : ", ") +
              (j == (k < kLensModes ? k : k - 2 * kNumLensModes) ? "4e-6" : "0");
    rows += "]\n";
  }
  const StereoRig read = ReadBack(CalibrationYaml(EurocRig()) + "covariance:\n  parameters: [" +
                                  names + "]\n  matrix:\n" + rows);
  ASSERT_TRUE(read.covariance);
  const VectorXd variances = read.covariance->diagonal();
  EXPECT_EQ(variances(kLensModes - 1), 4e-6);
  EXPECT_EQ(variances(kMountRotation), 4e-6);
  EXPECT_TRUE(SaysNothingOfLensModes(*read.covariance));
}

TEST_F(CalibrationWriterTest, WithoutACovarianceThereIsNone) {
  EXPECT_FALSE(ReadBack(CalibrationYaml(EurocRig())).covariance);
}

TEST_F(CalibrationWriterTest, WhatTheAxesAreOffByIsKept) {
  StereoRig rig = RigWithCovariance();
  EXPECT_EQ(ReadBack(CalibrationYaml(rig)).axes_sigma, 0);
  rig.axes_sigma = 1e-3;
  const std::string text = CalibrationYaml(rig);
  EXPECT_EQ(ReadBack(text).axes_sigma, 1e-3);
  EXPECT_THAT(ErrorOf(Replaced(text, "axes_sigma: 0.001", "axes_sigma: 5")),
              HasSubstr("in radians, such as 0.001"));
}

TEST_F(CalibrationWriterTest, ACovarianceThatIsNoneIsRefused) {
  const std::string good = CalibrationYaml(RigWithCovariance());
  EXPECT_THAT(ErrorOf(Replaced(good, "cam0_fy", "cam0_fz")), HasSubstr("parameters"));
  EXPECT_THAT(ErrorOf(Replaced(good, "- [1e-06, 3e-07", "- [1e-06, 4e-07")),
              HasSubstr("symmetric, but that of cam0_fy and cam0_fx is another one"));
  EXPECT_THAT(ErrorOf(Replaced(good, "- [1e-06, 3e-07", "- [-1e-06, 3e-07")),
              HasSubstr("positive diagonal"));
  EXPECT_THAT(ErrorOf(Replaced(good, "- [1e-06, 3e-07", "- [1e+12, 3e-07")),
              HasSubstr("the standard deviation of cam0_fx is 1e+06 px"));
  EXPECT_THAT(ErrorOf(Replaced(good, "- [1e-06, 3e-07", "- [1e-20, 3e-07")),
              HasSubstr("the standard deviation of cam0_fx is 1e-10 px"));
  EXPECT_THAT(ErrorOf(Replaced(good, "- [1e-06, 3e-07,", "- [1e-06,")),
              HasSubstr("52 x 52 has 2704"));
  EXPECT_EQ(ErrorOf(good), "");
}

}  // namespace
}  // namespace facet
