// SPDX-License-Identifier: BSD-2-Clause
// Recordings with a calibration that cannot be right: one warning that names the cause, and none
// with the right one.
#include <filesystem>
#include <functional>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/testing/data_dir.h"
#include "facet/testing/io/program_run.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kRecordings[] = {"rendered_room", "euroc_mh01_handheld"};

class WrongCalibrationTest : public ::testing::Test {
 protected:
  /// A copy of the recording that shares its images and IMU.
  void Copy(const fs::path& recording) const {
    fs::remove_all(Mav0());
    fs::create_directories(Mav0());
    fs::create_directory_symlink(recording / "mav0" / "imu0", Mav0() / "imu0");
    for (const char* camera : {"cam0", "cam1"}) {
      fs::create_directories(Mav0() / camera);
      for (const char* part : {"data", "data.csv"})
        fs::create_symlink(recording / "mav0" / camera / part, Mav0() / camera / part);
      fs::copy_file(recording / "mav0" / camera / "sensor.yaml", Mav0() / camera / "sensor.yaml");
    }
  }

  /// What some seconds of the copy have to say on stderr.
  std::string Complaints(int duration_s = 8, const std::string& options = "") const {
    const ProgramRun run =
        RunFacet("run " + (folder_ / "seq").string() + " --pipeline S --duration " +
                 std::to_string(duration_s) + " --quiet --out " + (folder_ / "out").string() +
                 " --set mesh.enabled=false " + options);
    const std::string summary = ReadText(folder_ / "out" / "summary.json");
    const bool is_kept = summary.find("\"warnings\": []") == run.err.npos;
    EXPECT_EQ(is_kept, !run.err.empty()) << run.err;
    return run.err;
  }

  fs::path Mav0() const { return folder_ / "seq" / "mav0"; }
  TempFolder folder_;
};

TEST_F(WrongCalibrationTest, TheRightOneGivesNoWarning) {
  for (const char* name : kRecordings) {
    const auto recording = testing::DataDir(name);
    if (!recording) GTEST_SKIP() << testing::MissingData(name);
    Copy(*recording);
    EXPECT_THAT(Complaints(), IsEmpty()) << name;
  }
}

TEST_F(WrongCalibrationTest, SwappedCameras) {
  for (const char* name : kRecordings) {
    const auto recording = testing::DataDir(name);
    if (!recording) GTEST_SKIP() << testing::MissingData(name);
    Copy(*recording);
    for (const char* part : {"data", "data.csv"}) {
      fs::rename(Mav0() / "cam0" / part, Mav0() / "left");
      fs::rename(Mav0() / "cam1" / part, Mav0() / "cam0" / part);
      fs::rename(Mav0() / "left", Mav0() / "cam1" / part);
    }
    EXPECT_THAT(Complaints(8, "--set check_calibration=false"),
                HasSubstr("are the cameras swapped"))
        << name;
  }
}

TEST_F(WrongCalibrationTest, TimeOffset) {
  for (const char* name : kRecordings) {
    const auto recording = testing::DataDir(name);
    if (!recording) GTEST_SKIP() << testing::MissingData(name);
    Copy(*recording);
    for (const char* camera : {"cam0", "cam1"}) {
      const fs::path yaml = Mav0() / camera / "sensor.yaml";
      WriteText(yaml, ReadText(yaml) + "\ntimeshift_cam_imu: 0.05\n");
    }
    EXPECT_THAT(Complaints(14), HasSubstr("time offset -")) << name;
  }
}

// What `facet run` makes of a recording with a fault of `facet simulate`.
class GrosslyWrongCalibrationTest : public ::testing::TestWithParam<const char*> {
 protected:
  ProgramRun Run(const fs::path& recording, const std::string& fault) const {
    const fs::path sequence = folder_ / "seq";
    fs::remove_all(sequence);
    const ProgramRun planted = RunFacet("simulate --quiet --of " + recording.string() +
                                        " --fault " + fault + " --out " + sequence.string());
    EXPECT_EQ(planted.exit_code, 0) << planted.err;
    return RunFacet("run " + sequence.string() + " --pipeline S --quiet --out " +
                    (folder_ / "out").string() + " --set mesh.enabled=false");
  }

  TempFolder folder_;
};

TEST_P(GrosslyWrongCalibrationTest, IsRefusedWithTheReason) {
  const auto recording = testing::DataDir(GetParam());
  if (!recording) GTEST_SKIP() << testing::MissingData(GetParam());
  const std::pair<const char*, const char*> faults[] = {
      {"imu_degrees", "the gyroscope measured in deg/s"},
      {"imu_negated:axis=0", "the IMU's axis x were negated"},
      {"imu_negated:axis=1", "the IMU's axis y were negated"},
      {"imu_negated:axis=2", "the IMU's axis z were negated"},
      {"inverted_T_BS", "T_BS of cam0 were inverted"},
      {"imu_frozen:at=-100,length=1e4", "the IMU has sent one value for "},
      {"imu_negated:axis=1,accel_only=1", "an axis of the accelerometer, y, shows the opposite"},
      {"imu_negated:axis=2,accel_only=1", "an axis of the accelerometer, z, shows the opposite"},
  };
  for (const auto& [fault, reason] : faults) {
    const ProgramRun run = Run(*recording, fault);
    EXPECT_EQ(run.exit_code, 3) << fault << ": " << run.err;
    EXPECT_THAT(run.err, HasSubstr(reason)) << fault;
    EXPECT_TRUE(fs::exists(folder_ / "out" / "summary.json")) << fault;
  }
}

// Told before anything is run.
TEST_P(GrosslyWrongCalibrationTest, SwappedCamerasAreRefused) {
  const auto recording = testing::DataDir(GetParam());
  if (!recording) GTEST_SKIP() << testing::MissingData(GetParam());
  const ProgramRun run = Run(*recording, "swapped");
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_THAT(run.err, HasSubstr("the cameras are swapped"));
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_P(GrosslyWrongCalibrationTest, FaultsOfSensorsAreNoReason) {
  const auto recording = testing::DataDir(GetParam());
  if (!recording) GTEST_SKIP() << testing::MissingData(GetParam());
  for (const char* fault : {"object:share=0.3,at=1",
                            "frozen:length=2,at=1",
                            "repeated:share=0.1",
                            "dropped:share=0.3",
                            "imu_frozen:length=1,at=1",
                            "imu_early:ms=20"}) {
    const ProgramRun run = Run(*recording, fault);
    EXPECT_EQ(run.exit_code, 0) << fault << ": " << run.err;
  }
}

TEST_P(GrosslyWrongCalibrationTest, ATurnedRightCameraIsMeasuredBeforeTheRun) {
  const auto recording = testing::DataDir(GetParam());
  if (!recording) GTEST_SKIP() << testing::MissingData(GetParam());
  // About y the images of one moment do not tell; the estimator takes care of that.
  for (const char* axis : {"0", "2"}) {
    const ProgramRun run = Run(*recording, std::string("right_turned:deg=0.2,axis=") + axis);
    EXPECT_EQ(run.exit_code, 0) << axis << ": " << run.err;
    EXPECT_THAT(run.err, HasSubstr("the right camera is turned by")) << axis;
    EXPECT_THAT(run.err, Not(HasSubstr("of the corners were found"))) << axis;
  }
}

TEST_P(GrosslyWrongCalibrationTest, ARightCameraThatIsKnockedIsFollowed) {
  const auto recording = testing::DataDir(GetParam());
  if (!recording) GTEST_SKIP() << testing::MissingData(GetParam());
  for (const auto& [axis, turned] :
       {std::pair{"0", "turned by 0.3"}, {"1", "turned by 0.00, 0.3"}}) {
    const ProgramRun run = Run(*recording, std::string("knocked:at=4,deg=0.3,axis=") + axis);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, HasSubstr(std::string("the right camera is ") + turned));
    EXPECT_THAT(run.err, Not(HasSubstr("of the corners were found")));
  }
}

TEST_P(GrosslyWrongCalibrationTest, CarefulCalibrationsAreLeftAlone) {
  const auto recording = testing::DataDir(GetParam());
  if (!recording) GTEST_SKIP() << testing::MissingData(GetParam());
  for (const char* seed : {"1", "2", "3"}) {
    const fs::path sequence = folder_ / (std::string("drawn") + seed);
    const ProgramRun drawn =
        RunFacet("simulate --quiet --of " + recording->string() + " --draw-calibration " + seed +
                 " --out " + sequence.string());
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    const ProgramRun run = RunFacet("run " + sequence.string() + " --pipeline S --quiet --out " +
                                    (folder_ / "out").string() + " --set mesh.enabled=false");
    EXPECT_EQ(run.exit_code, 0) << seed << ": " << run.err;
    EXPECT_THAT(run.err, Not(HasSubstr("turned"))) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Recordings, GrosslyWrongCalibrationTest, ::testing::ValuesIn(kRecordings));

}  // namespace
}  // namespace facet
