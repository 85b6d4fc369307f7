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

TEST_F(CalibrationWriterTest, WithoutACovarianceThereIsNone) {
  EXPECT_FALSE(ReadBack(CalibrationYaml(EurocRig())).covariance);
}

TEST_F(CalibrationWriterTest, ACovarianceThatIsNoneIsRefused) {
  const std::string good = CalibrationYaml(RigWithCovariance());
  EXPECT_THAT(ErrorOf(Replaced(good, "cam0_fy", "cam0_fz")), HasSubstr("parameters"));
  EXPECT_THAT(ErrorOf(Replaced(good, "- [1e-06, 3e-07", "- [1e-06, 4e-07")),
              HasSubstr("symmetric"));
  EXPECT_THAT(ErrorOf(Replaced(good, "- [1e-06, 3e-07", "- [-1e-06, 3e-07")),
              HasSubstr("positive"));
  EXPECT_THAT(ErrorOf(Replaced(good, "- [1e-06, 3e-07,", "- [1e-06,")),
              HasSubstr("32 x 32 has 1024"));
  EXPECT_EQ(ErrorOf(good), "");
}

}  // namespace
}  // namespace facet
