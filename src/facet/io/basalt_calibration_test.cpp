// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/basalt_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/testing/folders.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A turn by 90 deg about x: what is in front of the camera is along the IMU's -y.
constexpr const char* kFile = R"({"value0": {
  "T_imu_cam": [
    {"px": 0.04, "py": -0.07, "pz": 0.01, "qx": 0.7071067811865476, "qy": 0, "qz": 0, "qw": 0.7071067811865476},
    {"px": 0.15, "py": -0.07, "pz": 0.01, "qx": 0.7071067811865476, "qy": 0, "qz": 0, "qw": 0.7071067811865476}],
  "intrinsics": [
    {"camera_type": "ds", "intrinsics": {"fx": 158.3, "fy": 158.4, "cx": 254.9, "cy": 256.8, "xi": -0.172, "alpha": 0.594}},
    {"camera_type": "kb4", "intrinsics": {"fx": 190.9, "fy": 190.8, "cx": 252.5, "cy": 255.9,
                                          "k1": 0.003, "k2": 0.0008, "k3": -0.002, "k4": 0.0002}}],
  "resolution": [[512, 512], [512, 512]],
  "vignette": [],
  "calib_accel_bias": [0.1, 0, 0, 0, 0, 0, 0, 0, 0],
  "calib_gyro_bias": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
  "imu_update_rate": 200.0,
  "accel_noise_std": [0.016, 0.015, 0.016],
  "gyro_noise_std": [0.000282, 0.000282, 0.000282],
  "accel_bias_std": [0.001, 0.001, 0.001],
  "gyro_bias_std": [0.0001, 0.0001, 0.0001],
  "cam_time_offset_ns": -1500000
}})";

class BasaltCalibrationTest : public ::testing::Test {
 protected:
  Calibration Read() const {
    return FindCalibration(folder_ / "mav0", {folder_ / "calib.json", {}});
  }
  std::string Complaint(const char* from, const char* to) const {
    WriteText(folder_ / "calib.json", kFile);
    ReplaceInFile(folder_ / "calib.json", from, to);
    try {
      Read();
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }
  TempFolder folder_;
};

TEST_F(BasaltCalibrationTest, ReadsCamerasPosesAndNoise) {
  WriteText(folder_ / "calib.json", kFile);
  const Calibration read = Read();
  const CameraIntrinsics& left = read.rig.cameras[0].intrinsics();
  EXPECT_EQ(left.distortion, DistortionModel::kDoubleSphere);
  EXPECT_EQ(left.coefficients[0], -0.172);
  EXPECT_EQ(left.coefficients[1], 0.594);
  const CameraIntrinsics& right = read.rig.cameras[1].intrinsics();
  EXPECT_EQ(right.distortion, DistortionModel::kEquidistant);
  EXPECT_EQ(right.coefficients[2], -0.002);
  EXPECT_EQ(right.width, 512);
  EXPECT_LT((read.rig.T_BC[0] * Vector3d(0, 0, 1) - Vector3d(0.04, -1.07, 0.01)).norm(), 1e-12);
  EXPECT_NEAR(read.rig.baseline_m(), 0.11, 1e-12);
  EXPECT_EQ(read.rig.time_offset, Duration(-1500000));
  EXPECT_EQ(read.imu_noise.accel_noise, 0.016);
  EXPECT_EQ(read.imu_noise.gyro_walk, 0.0001);
  EXPECT_EQ(read.imu_noise.rate_hz, 200);
  EXPECT_THAT(read.source, AllOf(HasSubstr("Basalt"), HasSubstr("-0.001500 s")));
}

TEST_F(BasaltCalibrationTest, AUnifiedCameraIsAnExtendedOne) {
  WriteText(folder_ / "calib.json", kFile);
  ReplaceInFile(folder_ / "calib.json", "\"ds\"", "\"ucm\"");
  const CameraIntrinsics k = Read().rig.cameras[0].intrinsics();
  EXPECT_EQ(k.distortion, DistortionModel::kExtendedUnified);
  EXPECT_EQ(k.coefficients[0], 0.594);
  EXPECT_EQ(k.coefficients[1], 1);
}

TEST_F(BasaltCalibrationTest, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(Complaint("\"value0\"", "value0"), HasSubstr("calib.json: cannot be read"));
  EXPECT_THAT(Complaint("\"xi\"", "\"zeta\""),
              HasSubstr("calib.json: value0: intrinsics[0]: intrinsics: 'xi' is missing"));
  EXPECT_THAT(Complaint("\"ds\"", "\"division\""),
              HasSubstr("'division' is not supported (pinhole"));
  EXPECT_THAT(Complaint("158.3", "\"wide\""), HasSubstr("fx: a number is expected"));
  EXPECT_THAT(Complaint("158.3", "-158"), HasSubstr("unusable camera"));
  EXPECT_THAT(Complaint("[[512, 512], [512, 512]]", "[[512, 512]]"),
              HasSubstr("resolution: a list of at least 2"));
  EXPECT_THAT(Complaint("\"qw\": 0.7071067811865476", "\"qw\": 0.2"), HasSubstr("unit length"));
  EXPECT_THAT(Complaint("0.15,", "0.04,"), HasSubstr("at the same place"));
  EXPECT_THAT(Complaint("-1500000", "-15000000000"), HasSubstr("time offset above 1 s"));
  EXPECT_THAT(Complaint("[0.016, 0.015, 0.016]", "[0, 0, 0]"), HasSubstr("greater than 0"));
  std::filesystem::remove(folder_ / "calib.json");
  EXPECT_THROW(Read(), InputError);
}

}  // namespace
}  // namespace facet
