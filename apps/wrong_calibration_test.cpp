// SPDX-License-Identifier: BSD-2-Clause
// Recordings with a calibration that cannot be right: one warning that names the cause, and none
// with the right one.
#include <filesystem>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/testing/data_dir.h"
#include "facet/testing/io/program_run.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

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
  std::string Complaints(int duration_s = 8) const {
    const ProgramRun run =
        RunFacet("run " + (folder_ / "seq").string() + " --pipeline S --duration " +
                 std::to_string(duration_s) + " --quiet --out " + (folder_ / "out").string() +
                 " --set mesh.enabled=false");
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
    EXPECT_THAT(Complaints(), HasSubstr("are the cameras swapped")) << name;
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

}  // namespace
}  // namespace facet
