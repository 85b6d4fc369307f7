// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/calibration_file.h"

#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class CalibrationFileTest : public ::testing::Test {
 protected:
  CalibrationFileTest() {
    for (int i = 0; i < 2; ++i)
      WriteText(Sensor(i), TestCameraYaml(i));
    WriteText(Imu(), TestImuYaml());
  }
  std::filesystem::path Mav0() const { return folder_ / "mav0"; }
  std::filesystem::path Sensor(int i) const {
    return Mav0() / ("cam" + std::to_string(i)) / "sensor.yaml";
  }
  std::filesystem::path Imu() const { return Mav0() / "imu0" / "sensor.yaml"; }

  std::string Error(const CalibrationFiles& files = {}) const {
    try {
      FindCalibration(Mav0(), files);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  TempFolder folder_;
};

std::string MatrixText(const SE3& T) {
  std::ostringstream text;
  text.precision(17);
  Matrix4d M = Matrix4d::Identity();
  M.topLeftCorner<3, 3>() = T.R();
  M.topRightCorner<3, 1>() = T.p;
  for (int r = 0; r < 4; ++r) {
    text << "  - [" << M(r, 0) << ", " << M(r, 1) << ", " << M(r, 2) << ", " << M(r, 3) << "]\n";
  }
  return text.str();
}

/// The rig as Kalibr writes it. `second` is the extrinsics text of cam1.
std::string Camchain(const StereoRig& rig, const std::string& second) {
  const auto camera = [](const CameraModel& model) {
    const CameraIntrinsics& k = model.intrinsics();
    std::ostringstream text;
    text << "  camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: ["
         << k.coefficients[0] << ", " << k.coefficients[1] << ", " << k.coefficients[2] << ", "
         << k.coefficients[3] << "]\n  intrinsics: [" << k.fx << ", " << k.fy << ", " << k.cx
         << ", " << k.cy << "]\n  resolution: [" << k.width << ", " << k.height
         << "]\n  rostopic: /cam\n  timeshift_cam_imu: 0.0125\n";
    return text.str();
  };
  return "cam0:\n  T_cam_imu:\n" + MatrixText(rig.T_BC[0].Inverse()) + camera(rig.cameras[0]) +
         "cam1:\n" + second + camera(rig.cameras[1]);
}

const char* const kKalibrImu =
    "accelerometer_noise_density: 0.006\naccelerometer_random_walk: 0.0002\n"
    "gyroscope_noise_density: 0.0004\ngyroscope_random_walk: 4.0e-06\n"
    "rostopic: /imu0\nupdate_rate: 400.0\n";

double PoseError(const SE3& a, const SE3& b) {
  return (a.p - b.p).norm() + a.q.angularDistance(b.q);
}

TEST_F(CalibrationFileTest, ReadsEurocWithAndWithoutYamlLine) {
  const Calibration plain = FindCalibration(Mav0(), {});
  const CameraIntrinsics& k = plain.rig.cameras[0].intrinsics();
  EXPECT_EQ(k.width, 160);
  EXPECT_EQ(k.height, 120);
  EXPECT_EQ(k.fx, 100.5);
  EXPECT_EQ(k.fy, 101.25);
  EXPECT_EQ(k.distortion, DistortionModel::kRadialTangential);
  EXPECT_EQ(k.coefficients[3], 1.76187114e-05);
  EXPECT_NEAR(plain.rig.baseline_m(), 0.11004592927, 1e-10);
  EXPECT_NEAR(
      (plain.rig.T_BC[0] * Vector3d(1, 0, 0) - plain.rig.T_BC[0].p - Vector3d(0, 1, 0)).norm(),
      0,
      1e-12);
  EXPECT_EQ(plain.imu_noise.accel_noise, 2e-3);
  EXPECT_EQ(plain.rig.time_offset.ns, 0);
  EXPECT_THAT(plain.source, HasSubstr("T_BS maps camera to body"));
  EXPECT_TRUE(plain.warnings.empty());

  WriteText(Sensor(0), "%YAML:1.0\n" + TestCameraYaml(0));
  EXPECT_EQ(PoseError(FindCalibration(Mav0(), {}).rig.T_BC[0], plain.rig.T_BC[0]), 0);
}

TEST_F(CalibrationFileTest, BodyIsTheImuWhateverTheFileSays) {
  const SE3 before = FindCalibration(Mav0(), {}).rig.T_BC[0];
  ReplaceInFile(Imu(), "[1.0, 0.0, 0.0, 0.0,", "[1.0, 0.0, 0.0, 0.5,");
  const SE3 after = FindCalibration(Mav0(), {}).rig.T_BC[0];
  EXPECT_NEAR((after.p - before.p - Vector3d(-0.5, 0, 0)).norm(), 0, 1e-12);
}

TEST_F(CalibrationFileTest, KalibrIsTheInverseConvention) {
  const Calibration euroc = FindCalibration(Mav0(), {});
  const StereoRig& rig = euroc.rig;
  WriteText(folder_ / "imu.yaml", kKalibrImu);
  const std::string kinds[] = {"  T_cam_imu:\n" + MatrixText(rig.T_BC[1].Inverse()),
                               "  T_imu_cam:\n" + MatrixText(rig.T_BC[1]),
                               "  T_cn_cnm1:\n" + MatrixText(rig.T_C1C0())};
  for (const std::string& second : kinds) {
    WriteText(folder_ / "chain.yaml", Camchain(rig, second));
    const Calibration kalibr = FindCalibration(Mav0(), {folder_ / "chain.yaml", {}});
    EXPECT_LT(PoseError(kalibr.rig.T_BC[0], rig.T_BC[0]), 1e-9);
    EXPECT_LT(PoseError(kalibr.rig.T_BC[1], rig.T_BC[1]), 1e-9);
    EXPECT_EQ(kalibr.rig.time_offset.ns, 12500000);
    EXPECT_EQ(kalibr.rig.cameras[1].intrinsics().fx, 100.5);
    EXPECT_EQ(kalibr.imu_noise.gyro_noise, 0.0004);
    EXPECT_EQ(kalibr.imu_noise.rate_hz, 400);
    EXPECT_THAT(kalibr.source,
                AllOf(HasSubstr("T_cam_imu maps IMU to camera"), HasSubstr("t_cam +0.0125")));
  }
}

TEST_F(CalibrationFileTest, KalibrTransformsThatContradictEachOtherAreTold) {
  const StereoRig rig = FindCalibration(Mav0(), {}).rig;
  WriteText(folder_ / "imu.yaml", kKalibrImu);
  const auto warnings_with = [&](const SE3& T_C1C0) {
    const std::string second = "  T_cam_imu:\n" + MatrixText(rig.T_BC[1].Inverse()) +
                               "  T_cn_cnm1:\n" + MatrixText(T_C1C0);
    WriteText(folder_ / "chain.yaml", Camchain(rig, second));
    const Calibration read = FindCalibration(Mav0(), {folder_ / "chain.yaml", {}});
    EXPECT_LT(PoseError(read.rig.T_BC[1], rig.T_BC[1]), 1e-9);
    return read.warnings;
  };
  using ::testing::Contains;
  EXPECT_THAT(warnings_with(rig.T_C1C0()), ::testing::Not(Contains(HasSubstr("contradicts"))));
  const SE3 turn(ExpSO3({0, 0.5 * kDegree, 0}), Vector3d::Zero());
  EXPECT_THAT(
      warnings_with(turn * rig.T_C1C0()),
      Contains(HasSubstr("contradicts the cameras' transforms to the IMU by 0.50 deg and")));
  SE3 moved = rig.T_C1C0();
  moved.p.x() += 0.002;
  EXPECT_THAT(warnings_with(moved), Contains(HasSubstr("2.0 mm and is not used")));
}

TEST_F(CalibrationFileTest, KalibrFilesAreFoundInTheSequence) {
  const StereoRig rig = FindCalibration(Mav0(), {}).rig;
  const std::string chain = Camchain(rig, "  T_cn_cnm1:\n" + MatrixText(rig.T_C1C0()));
  WriteText(folder_ / "camchain-imucam.yaml", chain);
  EXPECT_THAT(FindCalibration(Mav0(), {}).warnings, ::testing::Contains(HasSubstr("not read")));
  std::filesystem::remove(Sensor(0));
  EXPECT_THAT(FindCalibration(Mav0(), {}).source, HasSubstr("camchain-imucam.yaml"));
  WriteText(folder_ / "camchain.yaml", "cam0:\n  camera_model: pinhole\n");
  EXPECT_THAT(FindCalibration(Mav0(), {}).source, HasSubstr("camchain-imucam.yaml"));
  WriteText(folder_ / "camchain.yaml", chain);
  EXPECT_THAT(Error(), HasSubstr("several camchain files"));
}

TEST_F(CalibrationFileTest, KalibrWithoutImuYamlWarns) {
  const StereoRig rig = FindCalibration(Mav0(), {}).rig;
  WriteText(folder_ / "camchain.yaml", Camchain(rig, "  T_cn_cnm1:\n" + MatrixText(rig.T_C1C0())));
  std::filesystem::remove_all(Mav0() / "cam0");
  std::filesystem::remove_all(Mav0() / "imu0");
  EXPECT_THAT(FindCalibration(Mav0(), {}).warnings, ::testing::Contains(HasSubstr("ADIS16448")));
}

TEST_F(CalibrationFileTest, WithoutDensitiesTheUsualOnesCountWithAWarning) {
  EditLines(Imu(), [](std::vector<std::string>& lines) {
    std::erase_if(lines, [](const std::string& line) { return line.starts_with("gyroscope_"); });
  });
  const Calibration some = FindCalibration(Mav0(), {});
  EXPECT_EQ(some.imu_noise.gyro_noise, ImuNoise().gyro_noise);
  EXPECT_EQ(some.imu_noise.gyro_walk, ImuNoise().gyro_walk);
  EXPECT_THAT(some.warnings,
              ::testing::ElementsAre(HasSubstr("'gyroscope_noise_density' is missing"),
                                     HasSubstr("'gyroscope_random_walk' is missing")));

  std::filesystem::remove(Imu());
  const Calibration none = FindCalibration(Mav0(), {});
  EXPECT_EQ(none.imu_noise.accel_noise, ImuNoise().accel_noise);
  EXPECT_EQ(PoseError(none.rig.T_BC[0], some.rig.T_BC[0]), 0);
  EXPECT_THAT(none.warnings, ::testing::ElementsAre(HasSubstr("imu0/sensor.yaml: no such file")));
}

TEST_F(CalibrationFileTest, EquidistantModel) {
  ReplaceInFile(Sensor(1), "radial-tangential", "equidistant");
  ReplaceInFile(Sensor(1), "[-0.28340811, 0.07395907,", "[0.0034, 0.0007,");
  EXPECT_EQ(FindCalibration(Mav0(), {}).rig.cameras[1].intrinsics().distortion,
            DistortionModel::kEquidistant);
}

TEST_F(CalibrationFileTest, AbsurdNoiseIsAWarning) {
  ReplaceInFile(Imu(), "gyroscope_noise_density: 1.6968e-04", "gyroscope_noise_density: 1.0");
  EXPECT_THAT(FindCalibration(Mav0(), {}).warnings,
              ::testing::Contains(AllOf(HasSubstr("gyroscope_noise_density"), HasSubstr(":8"))));
}

struct Damage {
  const char* from;
  const char* to;
  const char* message;
};

TEST_F(CalibrationFileTest, CameraErrorsNameFileAndLine) {
  const std::string good = TestCameraYaml(1);
  const Damage cases[] = {
      {"[0.0, -1.0, 0.0,", "[0.0, 0.0, 0.0,", "sensor.yaml:3: 'T_BS' is singular"},
      {"[0.0, -1.0, 0.0,", "[0.0, 1.0, 0.0,", "is a reflection"},
      {"[0.0, -1.0, 0.0,", "[nan, -1.0, 0.0,", "sensor.yaml:5: 'nan'"},
      {"[0.0, -1.0, 0.0,", "[-1.0, 0.0,", "has 16 numbers, here are 15"},
      {"0.0453689425024", "45.3689425024", "the unit must be metres"},
      {"0.0, 0.0, 0.0, 1.0]", "0.1, 0.0, 0.0, 1.0]", "is the matrix transposed?"},
      {"0.0453689425024", "-0.064676986768", "both cameras are at the same place"},
      {"intrinsics: [100.5", "intrinsics: [0", "sensor.yaml:12: unusable camera"},
      {"101.25, 80, 60]", "101.25, 0.5, 0.5]", "sensor.yaml:12: unusable camera: principal point"},
      {"intrinsics: [100.5,", "intrinsics: [", "must be [fu, fv, cu, cv]"},
      {"resolution: [160, 120]", "resolution: [160]", "[width, height]"},
      {"resolution: [160, 120]", "resolution: [160, -120]", "unusable camera"},
      {"T_BS:", "T_SC:", "'T_BS' is missing"},
      {"camera_model: pinhole", "camera_model: catadioptric", "'catadioptric' is not supported"},
      {"radial-tangential", "division", "'division' is not supported"},
      {"radial-tangential", "fov", "4 distortion coefficients, 1 is expected"},
      {"camera_model: pinhole", "camera_model: omni", "[xi, fu, fv, cu, cv]"},
      {", 1.76187114e-05]", "]", "3 distortion coefficients; 4, 5 or 8 are expected"},
      {"rate_hz: 20", "rate_hz: [20", "not valid YAML"},
      {"[-0.28340811,", "[1e300,", "sensor.yaml:14: unusable camera: no lens distorts so much"},
      {"1.76187114e-05]", "1e300]", "sensor.yaml:14: unusable camera: no lens is so skew"},
      {"1.76187114e-05]", "1e999]", "sensor.yaml:14: '1e999' where a finite number is expected"},
      {"intrinsics: [100.5", "intrinsics: [1e300", "sensor.yaml:12: unusable camera: focal"},
      {"resolution: [160, 120]", "resolution: [1e300, 120]", "sensor.yaml:10: unusable camera"},
  };
  for (const Damage& damage : cases) {
    WriteText(Sensor(1), good);
    ReplaceInFile(Sensor(1), damage.from, damage.to);
    EXPECT_THAT(Error(), AllOf(HasSubstr("cam1"), HasSubstr(damage.message)));
  }
}

TEST_F(CalibrationFileTest, CoefficientsNeedAModel) {
  const std::filesystem::path yaml = Sensor(0);
  EditLines(yaml, [](std::vector<std::string>& lines) {
    std::erase_if(lines,
                  [](const std::string& line) { return line.starts_with("distortion_model"); });
  });
  try {
    FindCalibration(Mav0(), {});
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no 'distortion_model'"));
  }
}

TEST_F(CalibrationFileTest, AbsurdNumbersOfTheImuNameFileAndLine) {
  const std::string good = TestImuYaml();
  const Damage cases[] = {
      {"gyroscope_noise_density: 1.6968e-04",
       "gyroscope_noise_density: 1e300",
       "imu0/sensor.yaml:8: 'gyroscope_noise_density' is 1e300"},
      {"gyroscope_noise_density: 1.6968e-04",
       "gyroscope_noise_density: 1e-300",
       "imu0/sensor.yaml:8: 'gyroscope_noise_density' is 1e-300"},
      {"gyroscope_noise_density: 1.6968e-04", "gyroscope_noise_density: inf", ":8: 'inf'"},
      {"rate_hz: 200", "rate_hz: 0", "'rate_hz' must be a rate"},
      {"rate_hz: 200", "rate_hz: 1e300", "'rate_hz' must be a rate"},
  };
  for (const Damage& damage : cases) {
    WriteText(Imu(), good);
    ReplaceInFile(Imu(), damage.from, damage.to);
    EXPECT_THAT(Error(), HasSubstr(damage.message));
  }
}

// A pipe would be waited for for ever.
TEST_F(CalibrationFileTest, WhatIsNoFileIsNotCalledMissing) {
  for (const std::filesystem::path& file : {Sensor(0), Imu()}) {
    WriteText(Sensor(0), TestCameraYaml(0));
    std::filesystem::remove(file);
    ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
    EXPECT_THAT(Error(), HasSubstr(file.string() + ": cannot be read as a file"));
    std::filesystem::remove(file);
  }
}

TEST_F(CalibrationFileTest, OtherErrors) {
  ReplaceInFile(Imu(), "1.6968e-04", "0");
  EXPECT_THAT(Error(),
              HasSubstr("sensor.yaml:8: 'gyroscope_noise_density' must be greater than 0"));
  EXPECT_THAT(Error({{}, Mav0() / "imu1.yaml"}), HasSubstr("imu1.yaml: no such file"));
  std::filesystem::remove(Sensor(0));
  EXPECT_THAT(Error(), HasSubstr("--calibration FILE"));
  WriteText(folder_ / "alone.yaml", "cam0:\n  camera_model: pinhole\n");
  EXPECT_THAT(Error({folder_ / "alone.yaml", {}}), HasSubstr("alone.yaml:"));
  EXPECT_THAT(Error({folder_ / "missing.yaml", {}}), HasSubstr("missing.yaml: no such file"));
}

}  // namespace
}  // namespace facet
