// SPDX-License-Identifier: BSD-2-Clause
// Recordings of image files in other layouts than EuRoC's, from the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/calibration_file.h"
#include "facet/io/calibration_writer.h"
#include "facet/testing/io/program_run.h"
#include "facet/testing/io/test_images.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class FolderLayoutsTest : public ::testing::Test {
 protected:
  // Images of noise: a start just comes about, and soon the position would be lost.
  FolderLayoutsTest() {
    options_.num_frames = 14;
    WriteTestSequence(Sequence(), options_);
  }
  fs::path Sequence() const { return folder_ / "room1"; }
  fs::path Mav0() const { return Sequence() / "mav0"; }

  /// Kalibr's calibration in `folder` instead of EuRoC's.
  void MoveCalibration(const fs::path& folder) const {
    const StereoRig rig = ReadEurocCalibration(Mav0(), {}).rig;
    fs::create_directories(folder);
    WriteCalibration(folder / "camchain.yaml", rig);
    fs::rename(Mav0() / "imu0/sensor.yaml", folder / "imu_config.yaml");
    fs::remove(Mav0() / "cam0/sensor.yaml");
    fs::remove(Mav0() / "cam1/sensor.yaml");
  }

  /// The PGM images of a camera as PNG with 16 bits, of which `bits` are used.
  void WriteDeepImages(const std::string& camera, int bits) const {
    for (int i = 0; i < options_.num_frames; ++i) {
      const fs::path file = Mav0() / camera / "data" / std::to_string(FrameStamp(options_, i));
      const std::string pgm = ReadText(file.string() + ".pgm");
      TestImage image{options_.width, options_.height, 1, {}};
      const auto num = static_cast<std::size_t>(options_.width * options_.height);
      for (std::size_t k = pgm.size() - num; k < pgm.size(); ++k) {
        const int grey = static_cast<unsigned char>(pgm[k]);
        image.samples.push_back(static_cast<std::uint16_t>(grey * ((1 << bits) - 1) / 255));
      }
      WriteText(file.string() + ".png", EncodePng(image, {16}));
      fs::remove(file.string() + ".pgm");
    }
    EditLines(Mav0() / camera / "data.csv", [](std::vector<std::string>& lines) {
      for (std::string& line : lines) {
        if (line.ends_with(".pgm")) line.replace(line.size() - 3, 3, "png");
      }
    });
  }

  ProgramRun Run(const fs::path& recording, const std::string& out) const {
    return RunFacet("run " + recording.string() +
                    " --set estimator.imu.gyro_noise_scale=3 --quiet --out " +
                    (folder_ / out).string());
  }

  TempFolder folder_;
  TestSequenceOptions options_;
};

TEST_F(FolderLayoutsTest, TheConfigOfAResultSaysWhatElseWasGiven) {
  ASSERT_EQ(Run(Sequence(), "plain").exit_code, 0);
  const std::string plain = ReadText(folder_ / "plain/config.yaml");
  EXPECT_TRUE(plain.starts_with("# Facet's parameters"));
  const std::string cut = "cut --start 0.05 --calibration " + Sequence().string();
  Run(Sequence(), cut);
  EXPECT_EQ(ReadText(folder_ / "cut/config.yaml"),
            "# Run with --start 0.05 --calibration " + Sequence().string() + "\n" + plain);
  EXPECT_EQ(RunFacet("config --config " + (folder_ / "cut/config.yaml").string()).exit_code, 0);
}

TEST_F(FolderLayoutsTest, RightAlignedImagesGiveTheTrajectoryOfTheScaledOnes) {
  ASSERT_EQ(Run(Sequence(), "plain").exit_code, 0);
  for (const char* camera : {"cam0", "cam1"})
    WriteDeepImages(camera, 12);
  const ProgramRun run = Run(Sequence(), "deep");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  // 12 bits of a value of 8 bits give back exactly that value.
  EXPECT_EQ(ReadText(folder_ / "deep/trajectory.tum"), ReadText(folder_ / "plain/trajectory.tum"));
  EXPECT_THAT(ReadText(folder_ / "deep/summary.json"), HasSubstr("12 bits are used"));
}

TEST_F(FolderLayoutsTest, APlainFolderGivesTheTrajectoryOfTheAslFolder) {
  MoveCalibration(Sequence());
  const ProgramRun asl = Run(Sequence(), "asl");
  ASSERT_EQ(asl.exit_code, 0) << asl.err;
  const fs::path flight = folder_ / "flight";
  fs::create_directories(flight);
  fs::rename(Mav0() / "cam0/data", flight / "left");
  fs::rename(Mav0() / "cam1/data", flight / "right");
  fs::rename(Mav0() / "imu0/data.csv", flight / "imu.csv");
  fs::rename(Sequence() / "camchain.yaml", flight / "camchain.yaml");
  fs::rename(Sequence() / "imu_config.yaml", flight / "imu.yaml");
  const ProgramRun run = Run(flight, "plain");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(ReadText(folder_ / "plain/trajectory.tum"), ReadText(folder_ / "asl/trajectory.tum"));
  const ProgramRun info = RunFacet("info " + flight.string());
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_THAT(info.out, HasSubstr("kind: folder in the plain layout"));
  EXPECT_THAT(info.out, HasSubstr("stereo pairs         14"));
}

TEST_F(FolderLayoutsTest, TheSlowImuOfKittiIsRefused) {
  const fs::path drive = folder_ / "2011_09_26_drive_0001_sync";
  std::string times;
  for (int i = 0; i < 5; ++i)
    times += "2011-09-26 13:02:25." + std::to_string(i) + "00000000\n";
  for (const char* folder : {"image_00", "image_01", "oxts"})
    WriteText(drive / folder / "timestamps.txt", times);
  const ProgramRun run = Run(drive, "out");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("the IMU has 10.0 Hz"));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
}

}  // namespace
}  // namespace facet
